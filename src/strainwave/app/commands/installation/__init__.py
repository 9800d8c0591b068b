"""Commands on the installation: its check, the completion of a shell, the skill of an assistant."""
