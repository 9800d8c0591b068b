"""What a project file may hold, from its models: a JSON Schema for editors, and the reference page."""
