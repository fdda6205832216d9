import { ApiProblem, type Api } from "./client";
import type { DataSet } from "./types";
import { checksumOf, startUpload, worthRetrying, type RunningUpload, type StallReason } from "./upload";
import { forgetUpload, rememberUpload, rememberedUpload } from "./upload_memory";

export interface LabelUploadEvents {
  /** The server knows of the upload. `labels` is the state of the scan's labels. */
  readonly announced: (labels: DataSet["labels"]) => void;
  readonly progress: (part: number) => void;
  /** Nothing gets through at the moment. The upload resumes by itself. */
  readonly stalled: (by: StallReason) => void;
  readonly done: () => void;
  readonly failed: (thrown: unknown) => void;
}

/** Thrown if the server has rejected an upload of labels permanently. */
export class LabelUploadError extends Error {}

const againMs = 3000;
/** Statuses of an upload that the server no longer has. */
const gone: readonly number[] = [404, 410];

/**
 * Sends the labels of a scan, with the mechanism of scans (upload.ts). It resumes after any interruption, and if the same
 * file is chosen again later, where it stopped.
 */
export class LabelUpload {
  private running: RunningUpload | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private stopped = false;
  private failures = 0;
  private readonly onOnline = () => this.running?.resume();

  constructor(
    private readonly api: Pick<Api, "addLabels" | "csrfToken">,
    private readonly store: Pick<Storage, "getItem" | "setItem">,
    private readonly id: string,
    private readonly bundle: Blob,
    private readonly events: LabelUploadEvents,
  ) {
    globalThis.addEventListener("online", this.onOnline);
    void this.begin();
  }

  stop(): void {
    this.stopped = true;
    globalThis.removeEventListener("online", this.onOnline);
    clearTimeout(this.timer);
    this.running?.stop();
  }

  private async begin(): Promise<void> {
    // The whole file counts, because an edited file often has the same length.
    const checksum = await checksumOf(this.bundle);
    const fingerprint = checksum && `labels ${this.id} ${checksum}`;
    const earlier = fingerprint ? rememberedUpload(this.store, fingerprint) : null;
    if (this.stopped) return;
    if (earlier) this.send(earlier.upload_url, () => void this.announce(fingerprint));
    else void this.announce(fingerprint);
  }

  private async announce(fingerprint: string | null): Promise<void> {
    try {
      const made = await this.api.addLabels(this.id, this.bundle.size);
      const upload = { data_set_id: this.id, upload_url: made.upload_url, bytes: this.bundle.size };
      if (fingerprint) rememberUpload(this.store, fingerprint, upload);
      if (this.stopped) return;
      this.events.announced(made.data_set.labels);
      this.send(upload.upload_url, () => this.fail(new LabelUploadError()));
    } catch (thrown) {
      if (this.stopped) return;
      if (!(thrown instanceof ApiProblem) || !worthRetrying(thrown.status, this.failures++) || thrown.status === 409) {
        this.fail(thrown);
        return;
      }
      this.events.stalled(thrown.status === 507 ? "storage_full" : "connection");
      this.timer = setTimeout(() => void this.announce(fingerprint), againMs);
    }
  }

  /** `onGone` is called if the server no longer has the upload. */
  private send(url: string, onGone: () => void): void {
    this.running = startUpload(this.bundle, url, () => this.api.csrfToken, {
      progress: (sent, total) => this.events.progress(sent / total),
      stalled: (by) => this.events.stalled(by),
      end: (end) => {
        this.running = null;
        if (end.kind === "done") {
          this.stop();
          forgetUpload(this.store, this.id);
          this.events.done();
        } else if (gone.includes(end.status)) onGone();
        else this.fail(new LabelUploadError());
      },
    });
  }

  private fail(thrown: unknown): void {
    this.stop();
    this.events.failed(thrown);
  }
}
