"""The methods of identification: one file each, found by itself; ``--method`` takes the file's name."""
