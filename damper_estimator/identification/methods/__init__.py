"""The methods of identification: one file each, discovered automatically; ``--method`` accepts the file's name."""
