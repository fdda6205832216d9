import { useEffect, useRef, useState } from "preact/hooks";
import type { Place } from "../../../live/place";
import type { FileOrder } from "../../../protocol/file_messages";
import { t } from "../../../texts";
import { FileShot, type FileState } from "../../../video/file_shot";
import { browser_parts, renderers_error, StillShot, type ShotOrder, type ShotState } from "../../../video/still_shot";
import { probe_stills } from "../../../video/tile_pixels";
import { browser_unseen } from "../../../video/unseen";
import { Icon } from "../../icons";
import { save_file } from "./save_file";

export type TakeOrder = ({ readonly kind: "still" } & ShotOrder) | FileOrder;

type State = ShotState | FileState;
interface Work {
  start(): void;
  stop(): void;
}

export interface Shot {
  /** Nothing: none was asked for, or what came of it was read. */
  readonly state: State | null;
  readonly film: boolean;
  readonly take: (order: TakeOrder) => void;
  readonly stop: () => void;
  readonly hide: () => void;
}

/** One picture or film at a time that is rendered to be taken away; given up when the viewer is left. */
export function use_shot(place: Place): Shot {
  const [state, set_state] = useState<State | null>(null);
  const [film, set_film] = useState(false);
  const work = useRef<Work | null>(null);
  const taking = useRef(false);
  const left = useRef(false);
  useEffect(() => () => {
    left.current = true;
    work.current?.stop();
  }, []);
  const take = async (order: TakeOrder) => {
    if (taking.current) return;
    taking.current = true;
    set_film(order.kind === "turntable" || order.kind === "tour");
    const tell = (now: State) => {
      taking.current = now.kind === "rendering";
      set_state(now);
    };
    const begun = order.kind === "still" ? await still(order, place, tell) : file(order, place, tell);
    if (left.current) return; // while it was tried what this browser shows
    work.current = begun;
    begun.start();
  };
  return { state, film, take: (order) => void take(order), stop: () => work.current?.stop(), hide: () => set_state(null) };
}

/** A session of its own, which is given back when the file is there or given up. */
function own_session(place: Place) {
  let id: string | null = null;
  return { door: place.door(null, (known) => (id = known)), leave: () => place.leave(id) };
}

function file(order: FileOrder, place: Place, tell: (state: FileState) => void): Work {
  const { door, leave } = own_session(place);
  return new FileShot(order, browser_unseen(door, (state) => {
    if (state.kind !== "rendering") leave();
    if (state.kind === "done") save_file(state.file);
    tell(state);
  }));
}

async function still(order: ShotOrder, place: Place, tell: (state: ShotState) => void): Promise<Work> {
  const sheet = new OffscreenCanvas(order.size.width, order.size.height);
  const context = sheet.getContext("2d", { alpha: false });
  const stills = await probe_stills();
  const { door, leave } = own_session(place);
  const heard = (state: ShotState) => {
    if (state.kind !== "rendering") leave();
    if (state.kind === "done") void sheet.convertToBlob({ type: "image/png" }).then(save_file);
    tell(state);
  };
  const exact = stills.length > 0 || order.error > 0 ? order : { ...order, error: renderers_error }; // this browser shows no lossless tiles
  return new StillShot(
    exact,
    {
      draw: ({ image }) => context?.drawImage(image, 0, 0),
      draw_tiles: (tiles) => {
        for (const { x, y, width, height, rgba } of tiles) context?.putImageData(new ImageData(rgba, width, height), x, y);
      },
    },
    browser_parts(door, stills, heard),
  );
}

/** How far the picture is. */
export function ShotLine({ shot: { state, film, stop, hide } }: { readonly shot: Shot }) {
  const text = film ? t.take.of_film : t.take.of_picture;
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
      <span>{said_of(state, text)}</span>
      <button type="button" class="icon-button" aria-label={t.take.hide} title={t.take.hide} onClick={hide}><Icon name="close" /></button>
    </div>
  );
}

function said_of(state: Exclude<State, { kind: "rendering" }>, text: typeof t.take.of_film | typeof t.take.of_picture): string {
  if (state.kind === "done") return text.saved;
  switch (state.trouble) {
    case "stopped":
      return text.stopped;
    case "refused_scene":
      return state.said || text.failed;
    case "busy":
      return t.take.busy;
    case "refused":
      return text.failed;
    default:
      return `${t.viewer.troubles[state.trouble]} ${text.stopped}`;
  }
}
