"""A tradeoff for people, from its document: tables, work-precision diagrams, and a page of both."""
