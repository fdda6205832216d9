/**
 * The upload bundle of docs/contracts.md: a POSIX tar (ustar) of files named 00001.dcm, 00002.dcm and so on. It is a
 * Blob of parts, so nothing is copied or read before it is sent. The same files give the same bytes, so an upload can
 * be resumed.
 */
const block = 512;

export function bundleSize(sizes: readonly number[]): number {
  return sizes.reduce((sum, size) => sum + block + Math.ceil(size / block) * block, 0) + 2 * block;
}

export function makeBundle(files: readonly Blob[]): Blob {
  const parts: BlobPart[] = [];
  files.forEach((file, i) => {
    parts.push(tarHeader(`${String(i + 1).padStart(5, "0")}.dcm`, file.size), file);
    const rest = file.size % block;
    if (rest > 0) parts.push(new Uint8Array(block - rest));
  });
  parts.push(new Uint8Array(2 * block));
  return new Blob(parts, { type: "application/octet-stream" });
}

function tarHeader(name: string, size: number): Uint8Array<ArrayBuffer> {
  const header = new Uint8Array(block);
  const put = (offset: number, text: string) => {
    for (let i = 0; i < text.length; i++) header[offset + i] = text.charCodeAt(i);
  };
  const octal = (value: number, digits: number) => value.toString(8).padStart(digits, "0") + "\0";
  put(0, name);
  put(100, octal(0o644, 7));
  put(108, octal(0, 7)); // owner
  put(116, octal(0, 7)); // group
  put(124, octal(size, 11));
  put(136, octal(0, 11)); // time
  put(148, "        "); // the checksum is computed with blanks in its place
  put(156, "0"); // type: a regular file
  put(257, "ustar\0" + "00");
  const sum = header.reduce((total, byte) => total + byte, 0);
  put(148, sum.toString(8).padStart(6, "0") + "\0 ");
  return header;
}
