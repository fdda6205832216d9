import { useEffect } from "preact/hooks";
import { droppedFiles } from "../scan/picked_files";
import { useLatest } from "./use_latest";

/**
 * Calls `onFiles` with the files that are dropped anywhere on the page. Otherwise, the browser
 * would leave the page and open the file.
 */
export function useDroppedFiles(onFiles: (files: File[]) => void): void {
  const latest = useLatest(onFiles);
  useEffect(() => {
    const leaving = new AbortController();
    const { signal } = leaving;
    addEventListener("dragover", (event) => event.preventDefault(), { signal });
    const take = (event: DragEvent) => {
      event.preventDefault();
      if (event.dataTransfer) void droppedFiles(event.dataTransfer).then((files) => latest.current(files));
    };
    addEventListener("drop", take, { signal });
    return () => leaving.abort();
  }, [latest]);
}
