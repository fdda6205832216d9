import { useEffect } from "preact/hooks";
import { canInflate } from "../../../slices/coding";
import type { Shown, Slices } from "../../../slices/model";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { Icon } from "../../icons";
import { useMedia } from "../../use_media";
import { CurvePane } from "./curve_pane";
import { SliceBar } from "./slice_bar";
import { paneOrder, SlicePane } from "./slice_pane";

const narrowPage = "(max-width: 700px), (max-height: 480px)";

/** The slices next to the picture, or a single one instead of it. */
export function SliceViews({ session, number }: { readonly session: ViewerSession; readonly number: number }) {
  const slices = session.slices;
  const volume = session.volume.value;
  const view = slices.view.value;
  if (view === "picture" || !volume) return null;
  return (
    <div class="slice-views">
      {paneOrder.map((plane) => {
        const stack = slices.stacks.value.get(plane);
        return stack && (view === "four" || view === plane) ? (
          <SlicePane
            key={plane}
            slices={slices}
            stack={stack}
            volume={volume}
            alone={view === plane}
            collaboration={session.collaboration}
            marks={session.marks}
            number={number}
          />
        ) : null;
      })}
      {view === "four" && !slices.following.value ? (
        <button
          type="button"
          class="icon-button slice-maximise slice-maximise-picture"
          aria-label={t.slices.maximise(t.slices.view.picture)}
          title={t.slices.maximise(t.slices.view.picture)}
          onClick={() => slices.maximise("picture")}
        >
          <Icon name="fullscreen" />
        </button>
      ) : null}
    </div>
  );
}

/** The slice along the curve, below all other views. */
export function CurvedSliceView({ session: { slices, volume } }: { readonly session: ViewerSession }) {
  if (!slices.curveShown.value || !volume.value) return null;
  return <CurvePane slices={slices} volume={volume.value} />;
}

/** The bar below the header while slices are shown. On a narrow page, it also switches between them and the picture. */
export function SlicesLine({ session }: { readonly session: ViewerSession }) {
  const slices = session.slices;
  const volume = session.volume.value;
  if (!slices.open.value || !slices.available.value || !volume) return null;
  const fault = !canInflate() ? t.slices.unsupported : slices.damaged.value ? t.slices.damaged : "";
  return (
    <section class="slice-line" aria-label={t.slices.bar}>
      <SliceBar slices={slices} volume={volume} />
      {fault ? (
        <p class="glass pill slice-fault" role="alert">
          {fault}
        </p>
      ) : null}
    </section>
  );
}

/** Switches between the picture alone and the slices, like the key V. */
export function SlicesButton({ session: { slices } }: { readonly session: ViewerSession }) {
  const narrow = useMedia(narrowPage);
  useEffect(() => {
    slices.narrow.value = narrow;
  }, [slices, narrow]);
  const shown = slices.open.value;
  if (!slices.available.value) return null;
  return (
    <button
      type="button"
      class="icon-button tool-slices"
      aria-label={shown ? t.slices.close : t.slices.open}
      title={shown ? t.slices.close : t.slices.open}
      aria-pressed={shown}
      disabled={slices.following.value}
      onClick={() => toggleSlices(slices)}
    >
      <Icon name="four" />
    </button>
  );
}

export function toggleSlices({ open, available, following }: Slices): void {
  if (available.value && !following.value) open.value = !open.value;
}

/** Shows only the focused view, or all four again. */
export function maximiseFocused(slices: Slices): void {
  if (!slices.open.value || slices.following.value) return;
  const pane = document.activeElement?.closest<HTMLElement>(".slice-pane");
  if (pane?.classList.contains("curve-pane")) return; // it is always shown below the others
  const plane = pane?.dataset.plane;
  const one = (plane ?? "picture") as Exclude<Shown, "four">;
  const view = slices.view.value;
  slices.maximise(view === "four" || view === one ? one : view);
}
