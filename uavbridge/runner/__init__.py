"""The composition root: missions into agents, the stepped and the paced runner, the judge."""
