/** "2026-03-31-142509" by the clock of this computer: two files never have one name. */
export function timeInName(now: Date): string {
  const two = (value: number) => String(value).padStart(2, "0");
  const day = [now.getFullYear(), two(now.getMonth() + 1), two(now.getDate())].join("-");
  return `${day}-${two(now.getHours())}${two(now.getMinutes())}${two(now.getSeconds())}`;
}

/** The file alone, under a name that says when it was saved and nothing of anybody. */
export function saveFile(file: Blob): void {
  const url = URL.createObjectURL(file);
  const link = document.createElement("a");
  link.href = url;
  link.download = `diaphane-${timeInName(new Date())}.${file.type === "video/mp4" ? "mp4" : "png"}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
