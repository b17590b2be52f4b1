"""What accuracy costs in time, on a scene and a machine: settings measured along each axis that the scene has."""
