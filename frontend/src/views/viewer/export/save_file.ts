/** Returns the local time as "2026-03-31-142509", so that no two files have the same name. */
export function timeInName(now: Date): string {
  const two = (value: number) => String(value).padStart(2, "0");
  const day = [now.getFullYear(), two(now.getMonth() + 1), two(now.getDate())].join("-");
  return `${day}-${two(now.getHours())}${two(now.getMinutes())}${two(now.getSeconds())}`;
}

const extensions: Readonly<Record<string, string>> = {
  "video/mp4": "mp4",
  "text/csv": "csv",
  "application/json": "json",
  "image/svg+xml": "svg",
};

/** Saves the file under a name that contains the time but nothing about the scan. */
export function saveFile(file: Blob): void {
  const url = URL.createObjectURL(file);
  const link = document.createElement("a");
  link.href = url;
  link.download = `diaphane-${timeInName(new Date())}.${extensions[file.type] ?? "png"}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
