import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import type { Place } from "../../../live/place";
import type { FileOrder } from "../../../protocol/file_messages";
import { t } from "../../../texts";
import { serverSentence } from "../../../texts/problem_text";
import { FileShot, type FileState } from "../../../video/file_shot";
import { browserParts, renderersError, StillShot, type ShotOrder, type ShotState } from "../../../video/still_shot";
import { probeStills } from "../../../video/tile_pixels";
import { browserBackgroundParts } from "../../../video/background_session";
import { percentText } from "../../format";
import type { Decorate } from "../../marks/in_pictures";
import { Icon } from "../../icons";
import { saveFile } from "./save_file";
import { secondsLeft, withProgress, type ProgressMark } from "./time_left";

const savedShownMs = 8000;

/** `decorate` draws marks on the finished picture. */
type StillOrder = { readonly kind: "still"; readonly decorate?: Decorate } & ShotOrder;
export type ExportOrder = StillOrder | FileOrder;

type State = ShotState | FileState;
interface Work {
  start(): void;
  stop(): void;
}

export interface Shot {
  /**
   * The state of the export. Null if nothing is being rendered and no result is waiting to be read.
   */
  readonly state: State | null;
  readonly video: boolean;
  /** The frames of a video, and 1 for a picture. */
  readonly frames: number;
  readonly progress: readonly ProgressMark[];
  readonly take: (order: ExportOrder) => void;
  readonly stop: () => void;
  readonly hide: () => void;
}

/** Renders one picture or video at a time for download. Leaving the viewer cancels it. */
export function useShot(place: Place): Shot {
  const [state, setState] = useState<State | null>(null);
  const [video, setVideo] = useState(false);
  const [frames, setFrames] = useState(1);
  const [progress, setProgress] = useState<readonly ProgressMark[]>([]);
  const work = useRef<Work | null>(null);
  const taking = useRef(false);
  const left = useRef(false);
  useEffect(
    () => () => {
      left.current = true;
      work.current?.stop();
    },
    [],
  );
  const hide = useCallback(() => setState(null), []);
  const take = async (order: ExportOrder) => {
    if (taking.current) return;
    taking.current = true;
    const isVideo = order.kind !== "still" && order.kind !== "picture";
    setVideo(isVideo);
    setFrames(isVideo ? order.frames : 1);
    setProgress([]);
    const tell = (now: State) => {
      taking.current = now.kind === "rendering";
      if (now.kind === "rendering") setProgress((before) => withProgress(before, now.done, performance.now()));
      setState(now);
    };
    const preparing = order.kind === "still" ? still(order, place, tell) : Promise.resolve(file(order, place, tell));
    const begun = await preparing.catch((thrown: unknown) => {
      taking.current = false;
      throw thrown;
    });
    if (left.current) return; // the viewer was left while the codecs were being tested
    work.current = begun;
    begun.start();
  };
  return {
    state,
    video,
    frames,
    progress,
    take: (order) => void take(order),
    stop: () => work.current?.stop(),
    hide,
  };
}

/** Returns the source of a separate session, which ends when the file is complete or cancelled. */
function ownSession(place: Place) {
  let id: string | null = null;
  return { ticketSource: place.fileTicketSource((known) => (id = known)), leave: () => place.leave(id) };
}

function file(order: FileOrder, place: Place, tell: (state: FileState) => void): Work {
  const { ticketSource, leave } = ownSession(place);
  return new FileShot(
    order,
    browserBackgroundParts(ticketSource, (state) => {
      if (state.kind !== "rendering") leave();
      if (state.kind === "done") saveFile(state.file);
      tell(state);
    }),
  );
}

async function still(order: StillOrder, place: Place, tell: (state: ShotState) => void): Promise<Work> {
  const sheet = new OffscreenCanvas(order.size.width, order.size.height);
  const context = sheet.getContext("2d", { alpha: false });
  const stills = await probeStills();
  const { ticketSource, leave } = ownSession(place);
  const onEvent = (state: ShotState) => {
    if (state.kind !== "rendering") leave();
    if (state.kind === "done" && context) order.decorate?.(context, order.size);
    if (state.kind === "done") void sheet.convertToBlob({ type: "image/png" }).then(saveFile);
    tell(state);
  };
  const exact = stills.length > 0 || order.error > 0 ? order : { ...order, error: renderersError }; // this browser cannot show lossless tiles
  return new StillShot(
    exact,
    {
      draw: ({ image }) => context?.drawImage(image, 0, 0),
      drawTiles: (tiles) => {
        for (const { x, y, width, height, rgba } of tiles)
          context?.putImageData(new ImageData(rgba, width, height), x, y);
      },
    },
    browserParts(ticketSource, stills, onEvent),
  );
}

/** The progress of the picture. */
export function ShotLine({ shot }: { readonly shot: Shot }) {
  const { state, video, hide } = shot;
  const text = video ? t.take.ofVideo : t.take.ofPicture;
  const expected = state?.kind === "done" || (state?.kind === "failed" && state.trouble === "stopped");
  useEffect(() => {
    if (!expected) return;
    const timer = setTimeout(hide, savedShownMs); // the line covers what lies below
    return () => clearTimeout(timer);
  }, [expected, hide]);
  if (state === null) return null;
  if (state.kind === "rendering") return <RenderingLine shot={shot} state={state} />;
  return (
    <div
      class={`glass pill shot-line${state.kind === "failed" && state.trouble !== "stopped" ? " pill-bad" : ""}`}
      data-shot={state.kind}
    >
      <Icon name={state.kind === "done" ? "check" : "alert"} />
      <span data-said>{saidOf(state, text)}</span>
      <button type="button" class="icon-button" aria-label={t.take.hide} title={t.take.hide} onClick={hide}>
        <Icon name="close" />
      </button>
    </div>
  );
}

interface RenderingLineProps {
  readonly shot: Shot;
  readonly state: Extract<State, { kind: "rendering" }>;
}

/** Says how much is done. A video takes minutes, so it also says how many are left. */
function RenderingLine({ shot: { video, frames, progress, stop }, state: { done, waits } }: RenderingLineProps) {
  const text = video ? t.take.ofVideo : t.take.ofPicture;
  const left = secondsLeft(progress);
  const rendered = Math.round((done ?? 0) * frames);
  const ofVideo = left === null ? t.take.framesBegun(rendered, frames) : t.take.framesDone(rendered, frames, left);
  const ofPicture = done === null ? "" : percentText(Math.floor(100 * done) / 100);
  const soFar = video ? ofVideo : ofPicture;
  return (
    <div class="glass pill shot-line" data-shot="rendering">
      <span class="shot-words">
        <span data-said>{waits ? t.viewer.troubles[waits] : text.rendering}</span>
        <span class={video ? "shot-left" : "shot-percent"} aria-hidden="true">
          {soFar}
        </span>
      </span>
      <progress
        aria-label={text.rendering}
        {...(done === null ? {} : { max: 1, value: done })}
        {...(video && soFar ? { "aria-valuetext": soFar } : {})}
      />
      <button type="button" class="button button-small" onClick={stop}>
        {t.cancel}
      </button>
    </div>
  );
}

function saidOf(
  state: Exclude<State, { kind: "rendering" }>,
  text: typeof t.take.ofVideo | typeof t.take.ofPicture,
): string {
  if (state.kind === "done") return text.saved;
  switch (state.trouble) {
    case "stopped":
      return text.stopped;
    case "refused_scene":
      return serverSentence(state.message, text.failed);
    case "busy":
      return t.take.busy;
    case "refused":
      return text.failed;
    default:
      return `${t.viewer.troubles[state.trouble]} ${text.stopped}`;
  }
}
