"""One file per physical effect; discovery finds a new file, and no other file is edited."""
