import { useEffect, useRef, useState } from "preact/hooks";
import type { Place } from "../../../live/place";
import { t } from "../../../texts";
import { probe_stills } from "../../../video/tile_pixels";
import { browser_parts, StillShot, type ShotOrder, type ShotState } from "../../../video/still_shot";
import { Icon } from "../../icons";
import { save_png } from "./save_png";

export interface Shot {
  /** Nothing: none was asked for, or what came of it was read. */
  readonly state: ShotState | null;
  readonly take: (order: ShotOrder) => void;
  readonly stop: () => void;
  readonly hide: () => void;
}

/** One picture at a time that is rendered to be taken away; given up when the viewer is left. */
export function use_shot(place: Place): Shot {
  const [state, set_state] = useState<ShotState | null>(null);
  const shot = useRef<StillShot | null>(null);
  useEffect(() => () => shot.current?.stop(), []);
  return {
    state,
    take: (order) => void begin(order, place, set_state).then((begun) => (shot.current = begun)),
    stop: () => shot.current?.stop(),
    hide: () => set_state(null),
  };
}

/** A session of its own, which is given back when the picture is there or given up. */
async function begin(order: ShotOrder, place: Place, tell: (state: ShotState) => void): Promise<StillShot> {
  const sheet = new OffscreenCanvas(order.size.width, order.size.height);
  const context = sheet.getContext("2d", { alpha: false });
  let id: string | null = null;
  const stills = await probe_stills();
  const heard = (state: ShotState) => {
    if (state.kind !== "rendering") place.leave(id);
    if (state.kind === "done") void sheet.convertToBlob({ type: "image/png" }).then(save_png);
    tell(state);
  };
  const exact = stills.length > 0 || order.error > 0 ? order : { ...order, error: 0.01 }; // this browser shows no lossless tiles
  const shot = new StillShot(
    exact,
    {
      draw: ({ image }) => context?.drawImage(image, 0, 0),
      draw_tiles: (tiles) => {
        for (const { x, y, width, height, rgba } of tiles) context?.putImageData(new ImageData(rgba, width, height), x, y);
      },
    },
    browser_parts(place.door(null, (known) => (id = known)), stills, heard),
  );
  shot.start();
  return shot;
}

/** How far the picture is. */
export function ShotLine({ shot: { state, stop, hide } }: { readonly shot: Shot }) {
  const text = t.take;
  if (state === null) return null;
  if (state.kind === "rendering") {
    const percent = state.done === null ? "" : `${Math.floor(100 * state.done)} %`;
    return (
      <div class="glass pill shot-line" data-shot="rendering">
        <span>{state.waits ? t.viewer.troubles[state.waits] : text.rendering}</span>
        <progress aria-label={text.rendering} {...(state.done === null ? {} : { max: 1, value: state.done })} />
        <span class="shot-percent" aria-hidden="true">{percent}</span>
        <button type="button" class="button button-small" onClick={stop}>{t.cancel}</button>
      </div>
    );
  }
  return (
    <div class={`glass pill shot-line${state.kind === "failed" && state.trouble !== "stopped" ? " pill-bad" : ""}`} data-shot={state.kind}>
      <Icon name={state.kind === "done" ? "check" : "alert"} />
      <span>{said_of(state)}</span>
      <button type="button" class="icon-button" aria-label={text.hide} title={text.hide} onClick={hide}><Icon name="close" /></button>
    </div>
  );
}

function said_of(state: Exclude<ShotState, { kind: "rendering" }>): string {
  if (state.kind === "done") return t.take.saved;
  if (state.trouble === "stopped") return t.take.stopped;
  if (state.trouble === "refused_scene") return state.said || t.take.failed;
  return state.trouble === "refused" ? t.take.failed : `${t.viewer.troubles[state.trouble]} ${t.take.stopped}`;
}
