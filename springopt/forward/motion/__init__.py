"""Motion in time: implicit steps of eight motions at once, and how they change with the candidate."""
