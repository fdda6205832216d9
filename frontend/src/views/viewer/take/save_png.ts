/** The picture alone, under a name that says nothing of anybody. */
export function save_png(png: Blob): void {
  const url = URL.createObjectURL(png);
  const link = document.createElement("a");
  link.href = url;
  link.download = "diaphane.png";
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
