import { navigate } from "./router";

let waiting: readonly File[] | null = null;

/** Opens the page that adds a scan with files that were dropped on another page. */
export function addFiles(files: readonly File[]): void {
  waiting = files;
  navigate("/add");
}

/** Returns the files that the page was opened with, only once. */
export function takeFilesForAdd(): readonly File[] | null {
  const files = waiting;
  waiting = null;
  return files;
}
