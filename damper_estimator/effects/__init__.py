"""One file per physical effect; a new file is found by itself, nothing else is edited."""
