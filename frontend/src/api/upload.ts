import { DefaultHttpStack, DetailedError, Upload, type HttpRequest, type HttpStack } from "tus-js-client";

/** The only place that knows tus-js-client (docs/adr/0021). */

export const partBytes = 8 * 1024 * 1024;

/** How an upload ended: done, or refused for good by the server with this status. */
export type UploadEnd = { readonly kind: "done" } | { readonly kind: "refused"; readonly status: number };

/** Why nothing is sent just now; the next try comes by itself. */
export type StallReason = "connection" | "storage_full";

export interface UploadEvents {
  progress(sent: number, total: number): void;
  stalled(by: StallReason): void;
  end(end: UploadEnd): void;
}

export interface RunningUpload {
  /** Stops sending; what has arrived stays at the server. */
  stop(): void;
  /** Sends again from where the server stands: after `stop`, or at once instead of after the wait that is on. */
  goOn(): void;
}

const waitsMs = [300, 1000, 2000, 4000, 8000];
const fullWaitMs = 60_000;
/** A token that was renewed in another window is known here within moments. */
const triesWithOldToken = 4;

/** Sends from where the server stands, part by part with a checksum each, and comes back after any cut by itself. */
export function startUpload(bundle: Blob, url: string, csrfToken: () => string, events: UploadEvents): RunningUpload {
  let sending = false;
  let failures = 0;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const goOn = () => {
    clearTimeout(timer);
    if (sending) return;
    sending = true;
    upload.start();
  };
  const upload = new Upload(bundle, {
    uploadUrl: url,
    chunkSize: partBytes,
    retryDelays: null, // ours know of restarts of the server, too
    storeFingerprintForResuming: false, // the library's own would keep more than a number
    httpStack: new ChecksumStack(),
    onBeforeRequest: (request) => request.setHeader("X-CSRF-Token", csrfToken()),
    onProgress: (sent, total) => events.progress(sent, total),
    onChunkComplete: () => {
      failures = 0;
    },
    onSuccess: () => {
      sending = false;
      events.end({ kind: "done" });
    },
    onError: (error) => {
      if (!sending) return; // stopped
      sending = false;
      const status = error instanceof DetailedError ? (error.originalResponse?.getStatus() ?? 0) : 0;
      if (!worthRetrying(status, failures)) {
        events.end({ kind: "refused", status });
        return;
      }
      const wait = status === 507 ? fullWaitMs : (waitsMs[Math.min(failures, waitsMs.length - 1)] ?? 8000);
      failures += 1;
      events.stalled(status === 507 ? "storage_full" : "connection");
      timer = setTimeout(goOn, wait);
    },
  });
  goOn();
  return {
    stop: () => {
      sending = false;
      clearTimeout(timer);
      void upload.abort(false).catch(() => undefined);
    },
    goOn,
  };
}

/** 403 the token is an older one, 409 the offset differs (ask again), 423 a part is still being written, 429 too fast, 460 damaged on the way. */
export const worthRetrying = (status: number, failures: number): boolean =>
  status === 0 ||
  status >= 500 ||
  [408, 409, 423, 429, 460].includes(status) ||
  (status === 403 && failures < triesWithOldToken);

/** Adds `Upload-Checksum` to each part, which the library leaves to others. */
class ChecksumStack implements HttpStack {
  private readonly plain = new DefaultHttpStack({});

  createRequest(method: string, url: string): HttpRequest {
    const request = this.plain.createRequest(method, url);
    if (method !== "PATCH") return request;
    const send = request.send.bind(request);
    request.send = async (body: unknown) => {
      const checksum = body instanceof Blob ? await checksumOf(body) : null;
      if (checksum !== null) request.setHeader("Upload-Checksum", checksum);
      return send(body);
    };
    return request;
  }

  getName(): string {
    return "ChecksumStack";
  }
}

/** Nothing where the browser gives no digests: outside a secure context. */
export async function checksumOf(part: Blob): Promise<string | null> {
  const subtle = (crypto as Partial<Crypto>).subtle;
  if (!subtle) return null;
  const digest = new Uint8Array(await subtle.digest("SHA-1", await part.arrayBuffer()));
  return `sha1 ${btoa(String.fromCharCode(...digest))}`;
}
