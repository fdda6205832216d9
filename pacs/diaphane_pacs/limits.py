"""The limits on what archives and devices send. docs/bounds.toml lists them."""

from __future__ import annotations

#: Results of a search. A search with more says so.
MOST_STUDIES = 100
MOST_SERIES = 500
MOST_RESULT_BYTES = 8 << 20
#: A value of a result is cut off here, so that all results fit into a response of api.
LONGEST_VALUE = 128
#: Seconds of a search, from the connection to the last byte. api waits three seconds longer.
SEARCH_SECONDS = 24
#: Seconds until a connection is open, and without a byte.
CONNECT_SECONDS = 5
IDLE_SECONDS = 20
#: Seconds of a fetch. Its token expires then.
FETCH_SECONDS = 3600
#: Attempts to get the images that are still missing after an interruption.
ATTEMPTS = 3
MOST_IMAGES = 20_000
#: Bytes of one image, such as an enhanced file with all slices, and of a series. The images of a fetch are read one by one.
MOST_IMAGE_BYTES = 512 << 20
MOST_SERIES_BYTES = 8 << 30
#: Fetches that run at the same time, and per account.
MOST_FETCHES = 4
MOST_ACCOUNT_FETCHES = 2
#: Finished fetches whose result is kept, for an hour.
MOST_FINISHED = 1000
#: Series of one STOW request, or of one caller that are not complete yet.
MOST_OPEN_SERIES = 20
MOST_ASSOCIATIONS = 8
MOST_STOW = 4
MOST_PART_HEADER = 4096
#: Bytes of the line before a chunk.
MOST_CHUNK_LINE = 256
#: Bytes of the spool of received series, unless the settings say another limit.
SPOOL_BYTES = 18 << 30
#: Bytes of the disk that the spool leaves free, or a twentieth of a small disk.
DISK_RESERVE_BYTES = 1 << 30
#: Seconds after which a received series that cannot be uploaded is given up: a long weekend.
SPOOL_SECONDS = 96 * 3600
#: Seconds for which one upload of it is continued. The server forgets it after a day.
UPLOAD_SECONDS = 12 * 3600
#: Longest pause between two attempts.
RETRY_SECONDS = 300
#: A series of which images are missing waits so many times longer for a sender that sends them again.
RESEND_FACTOR = 60
