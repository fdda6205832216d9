import type { Mpeg1Answer, Mpeg1Order } from "./mpeg1_worker";
import { pictureOf, type CodedPicture, type FrameDecoder, type Picture } from "./picture";

interface Pending {
  readonly resolve: (picture: Picture) => void;
  readonly reject: (why: Error) => void;
}

/**
 * Decodes MPEG-1 with jsmpeg in a worker of its own, which is loaded only when this object is
 * created.
 */
export class Mpeg1Decoder implements FrameDecoder {
  readonly independent = false;
  private readonly worker = new Worker(new URL("./mpeg1_worker.ts", import.meta.url), { type: "module" });
  private pending: Pending[] = [];
  private chained = false;

  constructor() {
    this.worker.onmessage = ({ data }: MessageEvent<Mpeg1Answer>) => {
      const waiting = this.pending.shift();
      if (!waiting) data?.close();
      else if (data) waiting.resolve(pictureOf(data));
      else waiting.reject(new Error("a damaged MPEG-1 frame"));
    };
    this.worker.onerror = () => this.failed(new Error("the MPEG-1 decoder could not be loaded"));
  }

  decode(frame: CodedPicture): Promise<Picture> {
    if (!frame.key && !this.chained) return Promise.reject(new Error("a frame without the key frame before it"));
    this.chained = true;
    return new Promise((resolve, reject) => {
      this.pending.push({ resolve, reject });
      const order: Mpeg1Order = {
        key: frame.key,
        data: frame.data as Uint8Array<ArrayBuffer>,
        width: frame.width,
        height: frame.height,
      };
      this.worker.postMessage(order);
    });
  }

  close(): void {
    this.worker.terminate();
    this.failed(new Error("closed"));
  }

  private failed(why: Error): void {
    const waiting = this.pending;
    this.pending = [];
    this.chained = false;
    for (const { reject } of waiting) reject(why);
  }
}
