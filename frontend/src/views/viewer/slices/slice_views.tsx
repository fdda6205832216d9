import { useEffect } from "preact/hooks";
import { can_inflate } from "../../../slices/coding";
import type { Shown } from "../../../slices/model";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import { SliceBar } from "./slice_bar";
import { pane_order, SlicePane } from "./slice_pane";

const narrow_page = "(max-width: 700px), (max-height: 480px)";

/** The slices beside the picture, or one of them in its place. */
export function SliceViews({ session }: { readonly session: ViewerSession }) {
  const slices = session.slices;
  const volume = session.volume.value;
  const view = slices.view.value;
  if (view === "picture" || !volume) return null;
  return (
    <div class="slice-views">
      {pane_order.map((plane) => {
        const stack = slices.stacks.value.get(plane);
        return stack && (view === "four" || view === plane) ? <SlicePane key={plane} slices={slices} stack={stack} volume={volume} alone={view === plane} /> : null;
      })}
      {view === "four" ? (
        <button type="button" class="icon-button slice-maximise slice-maximise-picture" aria-label={t.slices.maximise(t.slices.view.picture)} title={t.slices.maximise(t.slices.view.picture)}
          onClick={() => slices.maximise("picture")}>
          <Icon name="fullscreen" />
        </button>
      ) : null}
    </div>
  );
}

/** Below the page's head, while slices are shown; on a narrow page also the way between them and the picture. */
export function SlicesLine({ session }: { readonly session: ViewerSession }) {
  const slices = session.slices;
  const volume = session.volume.value;
  if (!slices.open.value || !volume) return null;
  const fault = !can_inflate() ? t.slices.unsupported : slices.damaged.value ? t.slices.damaged : "";
  return (
    <section class="slice-line" aria-label={t.slices.bar}>
      <SliceBar slices={slices} volume={volume} />
      {fault ? <p class="glass pill slice-fault" role="alert">{fault}</p> : null}
    </section>
  );
}

/** Between the picture alone and the slices; by the key V as well, and by M one of them alone. */
export function SlicesButton({ session }: { readonly session: ViewerSession }) {
  const slices = session.slices;
  useEffect(() => {
    const list = matchMedia(narrow_page);
    const changed = () => (slices.narrow.value = list.matches);
    changed();
    list.addEventListener("change", changed);
    return () => list.removeEventListener("change", changed);
  }, [slices]);
  useEffect(() => {
    const pressed = (event: KeyboardEvent) => {
      if (event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey || is_typing(event.target) || document.querySelector("dialog[open]")) return;
      const key = event.key.toLowerCase();
      if (key === "v") toggle(session);
      else if (key === "m") maximise_focused(session);
      else return;
      event.preventDefault();
    };
    addEventListener("keydown", pressed);
    return () => removeEventListener("keydown", pressed);
  }, [session]);
  const shown = slices.open.value;
  if (slices.stacks.value.size === 0) return null;
  return (
    <button type="button" class="icon-button tool-slices" aria-label={shown ? t.slices.close : t.slices.open} title={shown ? t.slices.close : t.slices.open}
      aria-pressed={shown} onClick={() => toggle(session)}>
      <Icon name="four" />
    </button>
  );
}

function toggle(session: ViewerSession): void {
  const { open, stacks } = session.slices;
  if (stacks.value.size > 0) open.value = !open.value;
}

function maximise_focused(session: ViewerSession): void {
  const slices = session.slices;
  if (!slices.open.value) return;
  const plane = document.activeElement?.closest<HTMLElement>(".slice-pane")?.dataset.plane;
  const one = (plane ?? "picture") as Exclude<Shown, "four">;
  const view = slices.view.value;
  slices.maximise(view === "four" || view === one ? one : view);
}

const is_typing = (target: EventTarget | null): boolean =>
  target instanceof HTMLElement && (target.isContentEditable || target.tagName === "SELECT" || target.tagName === "TEXTAREA" || (target instanceof HTMLInputElement && target.type === "text"));
