"""What can go wrong, in words for the operator."""

from __future__ import annotations


class BackupError(Exception):
    """A backup or a restore cannot be made. The message says why."""
