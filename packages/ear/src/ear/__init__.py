"""The robot's own ear and mouth: a client of the services, as the page is one."""
