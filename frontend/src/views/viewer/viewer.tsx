import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Region } from "../../cut/region";
import type { DataSet } from "../../api/types";
import { attach_gestures } from "../../input/attach";
import { command_of, type KeyCommand } from "../../input/keys";
import { own_place, type Place } from "../../live/place";
import { role_of } from "../../live/role";
import { local } from "../../storage";
import { t } from "../../texts";
import { device_pixels, watch_device_pixels } from "../../video/canvas_size";
import { chosen_codecs, probe_codecs } from "../../video/ladder";
import { Painter } from "../../video/painter";
import { probe_stills } from "../../video/tile_pixels";
import { ViewerSession } from "../../video/viewer_session";
import { CutPanel } from "../cut/cut_panel";
import { focused_of } from "../focused";
import { Icon } from "../icons";
import { InPicture } from "../picture/in_picture";
import { PictureHandles } from "../picture/picture_handles";
import { PointPicker } from "../picture/point_picker";
import { Link } from "../router";
import { title_of } from "../scan_card";
import { ShareScanDialog } from "../share_scan";
import { useApp } from "../state";
import { ThemeSwitch } from "../shell";
import { HelpDialog } from "./help_dialog";
import { Hints } from "./hints";
import { LiveLine } from "./live_line";
import { OrientationCube } from "./orientation_cube";
import { PictureTimeLine } from "./picture_time";
import { Presets } from "./presets";
import { QualityPanel } from "./quality_panel";
import { RecordedInteraction, RecordingDialog } from "./recording";
import { SavedPresets, WantedPreset } from "./saved_presets";
import { Settings } from "./settings/settings";
import { ShareDialog } from "./share_dialog";
import { maximise_focused, SlicesButton, SlicesLine, SliceViews, toggle_slices } from "./slices/slice_views";
import { StatusLine } from "./status_line";
import { LinkedView } from "./take/linked_view";
import { ShotLine, use_shot } from "./take/shot";
import { TakeDialog } from "./take/take_dialog";

/** One's own scan. */
export function OwnViewer({ data_set_id }: { readonly data_set_id: string }) {
  const app = useApp();
  const [set, set_set] = useState<DataSet | null>(null);
  const place = useMemo(() => own_place(app.api, data_set_id), [app, data_set_id]);
  useEffect(() => {
    app.api.data_set(data_set_id).then(set_set, () => undefined); // the stream says what is wrong
  }, [app, data_set_id]);
  return <Viewer place={place} title={set ? title_of(set) : ""} set={set} onChange={set_set} />;
}

export interface ViewerProps {
  readonly place: Place;
  readonly title: string;
  /** Of a person with an account: what is known of the scan. */
  readonly set?: DataSet | null;
  readonly onChange?: (set: DataSet) => void;
  /** The picture is there to be cut: what is to be kept, of the volume with that hash. */
  readonly onCut?: (region: Region, volume_hash: string) => void;
}

export function Viewer({ place, title, set = null, onChange = () => undefined, onCut }: ViewerProps) {
  const page = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [session, set_session] = useState<ViewerSession | null>(null);
  const [fault, set_fault] = useState("");
  const [open, set_open] = useState<"help" | "share" | "recording" | "scan" | "presets" | "take" | null>(null);
  const picture = useMemo(() => new InPicture(), [place]);
  const own = place.data_set_id !== null;
  const shot = use_shot(place);
  const role = role_of(session?.audience.value ?? null);

  useEffect(() => {
    document.title = `${title || t.titles.view} · ${t.name}`;
  }, [title]);

  useEffect(() => {
    const element = canvas.current;
    if (!element) return;
    if (document.activeElement === document.body) element.focus(); // the link that led here is gone
    const leaving = new AbortController();
    let opened: ViewerSession | null = null;
    void Promise.all([probe_codecs(chosen_codecs(local)), probe_stills()]).then(([codecs, stills]) => {
      if (leaving.signal.aborted) return;
      if (codecs.length === 0) {
        set_fault(t.viewer.no_codec);
        return;
      }
      opened = new ViewerSession(place, new Painter(element), device_pixels(element), { codecs, stills }, local);
      connect_page(opened, element, leaving.signal);
      opened.start();
      set_session(opened);
    });
    return () => {
      leaving.abort();
      opened?.leave();
    };
  }, [place]);

  const obey = (command: KeyCommand) => {
    if (!session) return;
    switch (command.kind) {
      case "gesture":
        session.act(command.gesture);
        break;
      case "reset":
        session.reset_camera();
        break;
      case "preset": {
        const preset = session.presets.value[command.index];
        if (preset) session.apply_preset(preset);
        break;
      }
      case "fullscreen":
        if (page.current) void toggle_fullscreen(page.current);
        break;
      case "screenshot":
        set_open("take");
        break;
      case "help":
        set_open("help");
        break;
      case "slices":
        if (!onCut) toggle_slices(session.slices);
        break;
      case "alone":
        maximise_focused(session.slices);
        break;
    }
  };
  const latest = useRef(obey);
  latest.current = obey;

  useEffect(() => {
    const pressed = (event: KeyboardEvent) => {
      if (event.defaultPrevented || document.querySelector("dialog[open]")) return;
      const command = command_of({ key: event.key, shift: event.shiftKey, ctrl: event.ctrlKey, alt: event.altKey, meta: event.metaKey }, focused_of(event.target));
      if (!command) return;
      event.preventDefault();
      latest.current(command);
    };
    addEventListener("keydown", pressed);
    return () => removeEventListener("keydown", pressed);
  }, []);

  const tool = (name: "reset" | "fullscreen" | "screenshot" | "help", icon: "reset" | "fullscreen" | "camera" | "help") => (
    <button type="button" class={`icon-button tool-${name}`} aria-label={t.viewer[name]} title={t.viewer[name]} onClick={() => obey({ kind: name })}>
      <Icon name={icon} />
    </button>
  );

  return (
    <div class="viewer" ref={page} data-slices={session?.slices.open.value ? session.slices.view.value : undefined}>
      <main class="stage">
        <canvas ref={canvas} tabIndex={0} role="application" aria-label={t.viewer.stage} {...facts_of(session)} onDblClick={() => session?.slices.open.value && session.slices.maximise("picture")} />
        {session ? <SliceViews session={session} /> : null}
        {session && role.presents && !onCut ? <PictureHandles session={session} picture={picture} /> : null}
        {session && role.presents ? <PointPicker picture={picture} /> : null}
      </main>
      <header class="viewer-top">
        <div class="glass viewer-title">
          {own ? <Link href="/scans" class="icon-button" label={t.viewer.back}><Icon name="back" /></Link> : null}
          <h1>{title}</h1>
        </div>
        <div class="glass viewer-tools">
          {session && !onCut ? <SlicesButton session={session} /> : null}
          {tool("reset", "reset")}
          {tool("screenshot", "camera")}
          {tool("fullscreen", "fullscreen")}
          <ThemeSwitch />
          {own ? (
            <button type="button" class="icon-button tool-recording" aria-label={t.recording.open} title={t.recording.open} onClick={() => set_open("recording")}>
              <Icon name="record" />
            </button>
          ) : null}
          {set ? (
            <button type="button" class="icon-button tool-presets" aria-label={t.presets.open} title={t.presets.open} onClick={() => set_open("presets")}>
              <Icon name="star" />
            </button>
          ) : null}
          {set?.owned ? (
            <button type="button" class="icon-button tool-scan" aria-label={t.sharing.open} title={t.sharing.open} onClick={() => set_open("scan")}>
              <Icon name="globe" />
            </button>
          ) : null}
          <button type="button" class="icon-button tool-share" aria-label={role.others > 0 ? t.live.open_here(role.others + 1) : t.live.open} title={t.live.open} onClick={() => set_open("share")}>
            <Icon name="people" />
            {role.others > 0 ? <span class="count">{role.others + 1}</span> : null}
          </button>
          {tool("help", "help")}
        </div>
      </header>
      {session ? <SlicesLine session={session} /> : null}
      <StatusLine session={session} fault={fault}>
        {own ? <PictureTimeLine onHide={() => canvas.current?.focus()} /> : null}
        <ShotLine shot={shot} />
      </StatusLine>
      {session && role.follows ? <LiveLine session={session} role={role} /> : null}
      {session && session.connection.value.trouble !== "time_spent" ? (
        <>
          <OrientationCube session={session} />
          {onCut && place.data_set_id !== null ? <CutPanel session={session} data_set_id={place.data_set_id} onConfirm={onCut} /> : null}
          {role.presents && !onCut ? <Presets session={session} /> : null}
          {onCut ? null : <Settings session={session} leads={role.presents} cuts={!role.guest} picture={picture} />}
          {onCut ? null : <QualityPanel session={session} />}
          {role.presents && !onCut && session.picture.value ? <Hints onDone={() => canvas.current?.focus()} /> : null}
        </>
      ) : null}
      {open === "help" ? <HelpDialog onClose={() => set_open(null)} /> : null}
      {open === "share" && session ? <ShareDialog session={session} role={role} owner={own} onClose={() => set_open(null)} /> : null}
      {open === "scan" && set ? <ShareScanDialog set={set} onChange={onChange} onClose={() => set_open(null)} /> : null}
      {open === "presets" && set && session ? <SavedPresets session={session} set={set} onClose={() => set_open(null)} /> : null}
      {session && place.data_set_id !== null && role.presents && !onCut ? (
        <>
          <WantedPreset session={session} />
          <LinkedView session={session} />
        </>
      ) : null}
      {open === "take" && session ? (
        <TakeDialog session={session} rendered={own} busy={shot.state?.kind === "rendering"} onTake={(order) => {
          set_open(null);
          shot.take(order);
        }} onClose={() => set_open(null)} />
      ) : null}
      {open === "recording" ? <RecordingDialog onClose={() => set_open(null)} /> : null}
      {own && session ? <RecordedInteraction session={session} /> : null}
    </div>
  );
}

/** What picture is shown, for whoever looks at the page from outside (a test, a screen reader's user script). */
function facts_of(session: ViewerSession | null): Record<string, string> {
  const facts = session?.picture.value;
  if (!facts) return {};
  const lossless = session.lossless.value;
  return {
    ...(lossless ? { "data-lossless": String(lossless.samples) } : {}),
    "data-epoch": String(facts.epoch),
    "data-input-seq": String(facts.input_seq),
    "data-samples": String(facts.samples),
    "data-error": String(facts.error),
  };
}

/** Ties a session to what happens to the page and to hands on the picture. */
function connect_page(session: ViewerSession, element: HTMLCanvasElement, signal: AbortSignal): void {
  attach_gestures(element, (gesture, held) => session.act(gesture, held), () => session.rest(), signal);
  watch_device_pixels(element, (size) => {
    if (size.width > 0) session.resize(size); // behind a slice that is shown alone it has none
  }, signal);
  const seen = () => session.set_visible(!document.hidden && session.slices.picture_shown.value);
  document.addEventListener("visibilitychange", seen, { signal });
  element.addEventListener("contextrestored", () => session.show_anew(), { signal }); // a lost GPU has taken the picture along
  const forget = session.slices.picture_shown.subscribe(seen);
  signal.addEventListener("abort", forget);
  addEventListener("online", () => session.wake(), { signal });
  addEventListener("pagehide", () => session.remember(), { signal });
}

async function toggle_fullscreen(element: HTMLElement): Promise<void> {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await element.requestFullscreen();
  } catch {
    // Not allowed here (a phone, a frame): the page stays as it is.
  }
}
