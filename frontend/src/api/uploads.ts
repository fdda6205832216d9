import { signal, type ReadonlySignal } from "@preact/signals";
import { make_bundle } from "../scan/bundle";
import { local } from "../storage";
import { ApiProblem, type Api } from "./client";
import { random_key } from "./random_key";
import { OtherWindows } from "./other_windows";
import { start_upload, type RunningUpload } from "./upload";
import { forget_upload, remember_upload, remembered_upload, type RememberedUpload } from "./upload_memory";
import { begun, hindered, in_phase, is_open, next_to_send, refused, with_progress, type UploadView } from "./upload_view";

export type { UploadView } from "./upload_view";

/** More would only share the same line, and the browser opens six connections at most. */
const at_once = 3;
const told_every_ms = 1000;

interface Own {
  readonly bundle: Blob;
  readonly url: string;
  running: RunningUpload | null;
}

/** Thrown by `start`: another window of this browser sends these files. */
export class SentElsewhere extends Error {}

/** The uploads of this page. They go on while the person looks at other pages. */
export class Uploads {
  private readonly views_ = signal<ReadonlyMap<string, UploadView>>(new Map());
  private readonly own_ = new Map<string, Own>();
  private readonly others_ = new OtherWindows(() => this.merge_others(), () => this.own_views());
  private told_ms_ = -Infinity;

  constructor(private readonly api_: Api) {
    addEventListener("online", () => {
      for (const [id, own] of this.own_) if (this.phase(id) === "hindered") own.running?.go_on();
    });
    addEventListener("beforeunload", (event) => {
      if ([...this.views_.value.values()].some(is_open)) event.preventDefault(); // the browser asks whether to leave
    });
    setInterval(() => {
      this.tell_others();
      void this.others_.look();
    }, told_every_ms);
  }

  get views(): ReadonlySignal<ReadonlyMap<string, UploadView>> {
    return this.views_;
  }

  /** Begins, or goes on where these files were cut. Gives the data set's id once bytes can flow; rejects with ApiProblem or SentElsewhere. */
  async start(files: readonly Blob[], title: string, fingerprint: string): Promise<string> {
    const bundle = make_bundle(files);
    const earlier = await this.go_on_with(fingerprint, bundle.size);
    const upload = earlier ?? (await this.create(title, bundle.size, files.length));
    const id = upload.data_set_id;
    remember_upload(local, fingerprint, upload);
    this.own_.set(id, { bundle, url: upload.upload_url, running: null });
    this.show({ ...begun(id, bundle.size), sent: earlier?.received ?? 0 });
    this.send_next();
    this.others_.tell();
    return id;
  }

  /** The unfinished upload of these files that the server still has; it stands at `received` bytes. */
  async interrupted(fingerprint: string, bytes: number): Promise<(RememberedUpload & { readonly received: number }) | null> {
    const known = remembered_upload(local, fingerprint);
    if (known?.bytes !== bytes || this.own_.has(known.data_set_id)) return null;
    try {
      const { state, upload } = await this.api_.data_set(known.data_set_id);
      return state === "uploading" && upload?.bytes === bytes ? { ...known, received: upload.received_bytes } : null;
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.status === 404) return null; // deleted, expired or another person's
      throw thrown;
    }
  }

  pause(id: string): void {
    this.own_.get(id)?.running?.stop();
    this.change(id, (view) => in_phase(view, "paused"));
    this.send_next();
  }

  resume(id: string): void {
    this.change(id, (view) => in_phase(view, "waiting"));
    this.send_next();
  }

  /** Stops and removes it, here and at the server. */
  async cancel(id: string): Promise<void> {
    this.drop(id);
    forget_upload(local, id);
    this.send_next();
    await this.api_.delete_data_set(id);
  }

  /** The list of scans shows it as what it has become. */
  forget_sent(id: string): void {
    if (this.phase(id) === "sent") this.drop(id);
  }

  /** Somebody else signs in: nothing of the one before goes on. */
  stop_all(): void {
    for (const id of [...this.own_.keys()]) this.drop(id);
    this.views_.value = new Map();
  }

  /** As `interrupted`, and this window is the one that sends it from now on. */
  private async go_on_with(fingerprint: string, bytes: number): ReturnType<Uploads["interrupted"]> {
    const known = remembered_upload(local, fingerprint);
    if (known?.bytes !== bytes || this.own_.has(known.data_set_id)) return null;
    if (!(await this.others_.claim(known.data_set_id))) throw new SentElsewhere();
    let found: Awaited<ReturnType<Uploads["interrupted"]>> = null;
    try {
      found = await this.interrupted(fingerprint, bytes);
    } finally {
      if (!found) this.others_.release(known.data_set_id);
    }
    return found;
  }

  private async create(title: string, bytes: number, slices: number): Promise<RememberedUpload> {
    const made = await this.api_.create_data_set(title, bytes, slices, random_key());
    await this.others_.claim(made.data_set.id); // nobody else knows of it yet
    return { data_set_id: made.data_set.id, upload_url: made.upload_url, bytes };
  }

  private send_next(): void {
    for (;;) {
      const id = next_to_send(this.views_.value.values(), at_once);
      const own = id === null ? undefined : this.own_.get(id);
      if (id === null || !own) return;
      this.change(id, (view) => in_phase(view, "sending"));
      if (own.running) own.running.go_on();
      else own.running = this.send(id, own);
    }
  }

  private send(id: string, own: Own): RunningUpload {
    return start_upload(own.bundle, own.url, () => this.api_.csrf_token, {
      progress: (sent) => {
        this.change(id, (view) => with_progress(view, sent, performance.now()));
        this.tell_others();
      },
      hindered: (by) => this.change(id, (view) => hindered(view, by)),
      end: (end) => {
        if (end.kind === "done") {
          forget_upload(local, id);
          this.let_go(id);
          this.change(id, (view) => in_phase({ ...view, sent: view.total }, "sent"));
        } else {
          this.let_go(id);
          this.change(id, (view) => refused(view, end));
        }
        this.send_next();
      },
    });
  }

  private phase(id: string): UploadView["phase"] | undefined {
    return this.views_.value.get(id)?.phase;
  }

  private show(view: UploadView): void {
    this.views_.value = new Map(this.views_.value).set(view.data_set_id, view);
  }

  private change(id: string, to: (view: UploadView) => UploadView): void {
    const view = this.views_.value.get(id);
    if (view) this.show(to(view));
  }

  private own_views(): readonly UploadView[] {
    return [...this.views_.value.values()].filter((view) => is_open(view) && this.own_.has(view.data_set_id));
  }

  /** By the timer, which sleeps in a window in the background, and by what arrives, which wakes it. */
  private tell_others(): void {
    if (performance.now() - this.told_ms_ < told_every_ms / 2) return;
    this.told_ms_ = performance.now();
    this.others_.tell();
  }

  private merge_others(): void {
    const kept = [...this.views_.value].filter(([, view]) => view.phase !== "elsewhere");
    const heard = this.others_.views().filter((view) => !this.own_.has(view.data_set_id));
    if (heard.length === 0 && kept.length === this.views_.value.size) return;
    this.views_.value = new Map([...kept, ...heard.map((view) => [view.data_set_id, in_phase(view, "elsewhere")] as const)]);
  }

  /** This window has nothing more to send of it. */
  private let_go(id: string): void {
    if (this.own_.delete(id)) this.others_.release(id);
  }

  private drop(id: string): void {
    this.own_.get(id)?.running?.stop();
    this.let_go(id);
    const views = new Map(this.views_.value);
    views.delete(id);
    this.views_.value = views;
  }
}
