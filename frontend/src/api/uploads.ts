import { signal, type ReadonlySignal } from "@preact/signals";
import { make_bundle } from "../scan/bundle";
import { ApiProblem, random_key, type Api } from "./client";
import { start_upload, type RunningUpload } from "./upload";
import { forget_upload, remember_upload, remembered_upload, type RememberedUpload } from "./upload_memory";

export interface UploadView {
  readonly data_set_id: string;
  readonly sent: number;
  readonly total: number;
  /** Cut; the next try comes by itself. */
  readonly paused: boolean;
  readonly resumed: boolean;
  readonly failed: boolean;
}

/** The uploads of this page. They go on while the person looks at other pages. */
export class Uploads {
  private readonly views_ = signal<ReadonlyMap<string, UploadView>>(new Map());
  private readonly running_ = new Map<string, RunningUpload>();

  constructor(private readonly api_: Api) {}

  get views(): ReadonlySignal<ReadonlyMap<string, UploadView>> {
    return this.views_;
  }

  /** Begins, or goes on where these files were cut. Gives the data set's id once bytes can flow; rejects with ApiProblem. */
  async start(files: readonly Blob[], title: string, fingerprint: string): Promise<string> {
    const bundle = make_bundle(files);
    const earlier = await this.earlier(fingerprint, bundle.size);
    const upload = earlier ?? (await this.create(title, bundle.size, files.length));
    remember_upload(localStorage, fingerprint, upload);
    this.run(upload, bundle, earlier !== null);
    return upload.data_set_id;
  }

  /** Stops and removes it, here and at the server. */
  async cancel(data_set_id: string): Promise<void> {
    this.drop(data_set_id);
    forget_upload(localStorage, data_set_id);
    await this.api_.delete_data_set(data_set_id);
  }

  /** Somebody else signs in: nothing of the one before goes on. */
  stop_all(): void {
    for (const id of [...this.running_.keys()]) this.drop(id);
    this.views_.value = new Map();
  }

  private async create(title: string, bytes: number, slices: number): Promise<RememberedUpload> {
    const made = await this.api_.create_data_set(title, bytes, slices, random_key());
    return { data_set_id: made.data_set.id, upload_url: made.upload_url, bytes };
  }

  private async earlier(fingerprint: string, bytes: number): Promise<RememberedUpload | null> {
    const known = remembered_upload(localStorage, fingerprint);
    if (known?.bytes !== bytes || this.running_.has(known.data_set_id)) return null;
    try {
      const { state, upload } = await this.api_.data_set(known.data_set_id);
      return state === "uploading" && upload?.bytes === bytes ? known : null;
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.status === 404) return null; // deleted, expired or another person's
      throw thrown;
    }
  }

  private run(upload: RememberedUpload, bundle: Blob, resumed: boolean): void {
    const id = upload.data_set_id;
    this.show({ data_set_id: id, sent: 0, total: bundle.size, paused: false, resumed, failed: false });
    const running = start_upload(bundle, upload.upload_url, () => this.api_.csrf_token, {
      progress: (sent, total) => {
        // A cut is over when more arrives than before it, not when a try begins.
        const before = this.views_.value.get(id);
        this.change(id, { sent, total, paused: before?.paused === true && sent <= before.sent });
      },
      paused: () => this.change(id, { paused: true }),
      end: (end) => {
        this.running_.delete(id);
        if (end.kind === "done") {
          forget_upload(localStorage, id);
          this.drop(id);
        } else this.change(id, { failed: true });
      },
    });
    this.running_.set(id, running);
  }

  private show(view: UploadView): void {
    this.views_.value = new Map(this.views_.value).set(view.data_set_id, view);
  }

  private change(id: string, changes: Partial<UploadView>): void {
    const view = this.views_.value.get(id);
    if (view) this.show({ ...view, ...changes });
  }

  private drop(id: string): void {
    this.running_.get(id)?.stop();
    this.running_.delete(id);
    const views = new Map(this.views_.value);
    views.delete(id);
    this.views_.value = views;
  }
}
