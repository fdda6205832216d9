export interface StreamEnd {
  readonly bytes: Uint8Array<ArrayBuffer>;
  /** `more`: there was more than was wanted; `broken`: it ended before its end. Then `bytes` are what came until then. */
  readonly end: "whole" | "more" | "broken";
}

/** At most so many bytes: a short text may unpack to very many. Never throws. */
export async function readAtMost(stream: ReadableStream<Uint8Array<ArrayBuffer>>, most: number): Promise<StreamEnd> {
  const reader = stream.getReader();
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let length = 0;
  let end: StreamEnd["end"] = "whole";
  try {
    for (let next = await reader.read(); !next.done; next = await reader.read()) {
      parts.push(next.value.subarray(0, most - length));
      length += next.value.length;
      if (length <= most) continue;
      end = "more";
      break;
    }
  } catch {
    end = "broken";
  }
  await reader.cancel().catch(() => undefined);
  return { bytes: new Uint8Array(await new Blob(parts).arrayBuffer()), end };
}
