"""Encrypted backups of an installation with restic: the database and the files of its scans. See docs/operate.md."""
