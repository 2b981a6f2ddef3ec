"""Tables to the report's page."""
