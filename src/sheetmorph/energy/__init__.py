"""Energy terms with analytic derivatives, and their assembly."""
