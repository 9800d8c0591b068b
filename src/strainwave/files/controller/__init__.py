"""The group `controller` of a project file."""
