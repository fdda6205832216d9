/** Saves a file under a name that identifies nobody. */
export function saveFile(file: Blob): void {
  const url = URL.createObjectURL(file);
  const link = document.createElement("a");
  link.href = url;
  link.download = file.type === "video/mp4" ? "diaphane.mp4" : "diaphane.png";
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
