"""The page: one browser, from the session loop to the panels, the boards and the scene."""
