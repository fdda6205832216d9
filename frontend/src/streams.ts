export interface StreamEnd {
  readonly bytes: Uint8Array<ArrayBuffer>;
  /** `more`: the limit was reached. `broken`: the stream ended early. In both cases, `bytes` holds what arrived. */
  readonly end: "whole" | "more" | "broken";
}

/** Reads at most `most` bytes, because a short text can expand to a very long one. Never throws. */
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
