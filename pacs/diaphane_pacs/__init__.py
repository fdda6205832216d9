"""The PACS gateway: searches the hospital's archives, fetches series from them, and receives scans."""
