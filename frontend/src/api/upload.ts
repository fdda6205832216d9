import { DefaultHttpStack, DetailedError, Upload, type HttpRequest, type HttpStack } from "tus-js-client";

/** The only file that uses tus-js-client. */

export const partBounds = { first: 1 << 20, least: 1 << 18, most: 8 << 20 } as const;
/** Target duration of a part. A pause or a closed window loses the part in transit. */
const partMs = 2000;

/** Returns the size of the next part, after one of `bytes` took `ms`. */
export function nextPartBytes(bytes: number, ms: number): number {
  const target = (bytes * partMs) / Math.max(1, ms);
  return Math.round(Math.min(partBounds.most, Math.max(partBounds.least, target)));
}

/** How an upload ended: it is complete, or the server rejected it permanently with this status. */
export type UploadEnd = { readonly kind: "done" } | { readonly kind: "refused"; readonly status: number };

/** Why nothing can be sent at the moment. The upload retries automatically. */
export type StallReason = "connection" | "storage_full";

export interface UploadEvents {
  progress(sent: number, total: number): void;
  stalled(by: StallReason): void;
  end(end: UploadEnd): void;
}

export interface RunningUpload {
  /** Stops sending. The server keeps what has arrived. */
  stop(): void;
  /** Resumes at the server's offset after `stop`, or ends the current wait before a retry. */
  resume(): void;
}

const waitsMs = [300, 1000, 2000, 4000, 8000];
const fullWaitMs = 60_000;
/** Attempts with an outdated CSRF token. One that another window renewed arrives within moments. */
const triesWithOldToken = 4;

/** Uploads from the server's offset in parts with a checksum each, and resumes after any interruption. */
export function startUpload(bundle: Blob, url: string, csrfToken: () => string, events: UploadEvents): RunningUpload {
  let sending = false;
  let failures = 0;
  let partBegan = 0;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const resume = () => {
    clearTimeout(timer);
    if (sending) return;
    sending = true;
    partBegan = performance.now();
    upload.start();
  };
  const upload = new Upload(bundle, {
    uploadUrl: url,
    chunkSize: partBounds.first,
    retryDelays: null, // our own retries also handle restarts of the server
    storeFingerprintForResuming: false, // the library would store more than a number
    httpStack: new ChecksumStack(),
    onBeforeRequest: (request) => request.setHeader("X-CSRF-Token", csrfToken()),
    onProgress: (sent, total) => events.progress(sent, total),
    onChunkComplete: (bytes) => {
      failures = 0;
      const now = performance.now();
      upload.options.chunkSize = nextPartBytes(bytes, now - partBegan);
      partBegan = now;
    },
    onSuccess: () => {
      sending = false;
      events.end({ kind: "done" });
    },
    onError: (error) => {
      if (!sending) return; // `stop` was called
      sending = false;
      const status = error instanceof DetailedError ? (error.originalResponse?.getStatus() ?? 0) : 0;
      if (!worthRetrying(status, failures)) {
        events.end({ kind: "refused", status });
        return;
      }
      const wait = status === 507 ? fullWaitMs : (waitsMs[Math.min(failures, waitsMs.length - 1)] ?? 8000);
      failures += 1;
      events.stalled(status === 507 ? "storage_full" : "connection");
      timer = setTimeout(resume, wait);
    },
  });
  resume();
  return {
    stop: () => {
      sending = false;
      clearTimeout(timer);
      void upload.abort(false).catch(() => undefined);
    },
    resume,
  };
}

/**
 * Returns whether an upload may succeed later despite this HTTP status: 403 (outdated CSRF token),
 * 409 (offset differs), 423 (a part is still being written), 429 (too many requests) and 460
 * (corrupted in transit) are temporary, like timeouts and server errors.
 */
export const worthRetrying = (status: number, failures: number): boolean =>
  status === 0 ||
  status >= 500 ||
  [408, 409, 423, 429, 460].includes(status) ||
  (status === 403 && failures < triesWithOldToken);

/** Adds `Upload-Checksum` to each part, which the library does not do. */
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

/**
 * Returns the Upload-Checksum of a part. Returns null outside a secure context, where the browser
 * computes no digests.
 */
export async function checksumOf(part: Blob): Promise<string | null> {
  const subtle = (crypto as Partial<Crypto>).subtle;
  if (!subtle) return null;
  const digest = new Uint8Array(await subtle.digest("SHA-1", await part.arrayBuffer()));
  return `sha1 ${btoa(String.fromCharCode(...digest))}`;
}
