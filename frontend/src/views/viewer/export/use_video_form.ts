import { useEffect, useRef, useState } from "preact/hooks";
import type { PresetsApi } from "../../../api/sharing";
import type { FileOrder } from "../../../protocol/file_messages";
import type { Scene } from "../../../protocol/messages";
import { t } from "../../../texts";
import { longestVideoS } from "../../../video/file_shot";
import type { SceneEditor } from "../../../video/scene_editor";
import type { ViewerSession } from "../../../video/viewer_session";
import { fileMarksOf } from "../../marks/file_marks";
import { useApp } from "../../state";
import { sceneOfPreset } from "../preset_scene";
import {
  videoErrors,
  videoOrder,
  videoSides,
  videoSize,
  mostKeyViews,
  shortestAroundS,
  typedCycles,
  typedSeconds,
  usualCycles,
  type VideoQuality,
  type VideoSide,
  type KeyView,
} from "./video_size";

export interface VideoFormProps {
  readonly session: ViewerSession;
  readonly kind: "turntable" | "around" | "tour" | "phases";
  readonly busy: boolean;
  readonly onExport: (order: FileOrder) => void;
}

/** The entries of the user so far. */
export interface VideoEntries {
  readonly size: VideoSide;
  readonly quality: VideoQuality;
  readonly seconds: string;
  readonly rate: string;
  /** How often the phases of the scan are played. */
  readonly cycles: string;
  readonly views: readonly KeyView[];
  readonly withMarks: boolean;
}

interface Faults {
  readonly seconds: string;
  readonly cycles: string;
  readonly form: string;
}

const firstEntries: VideoEntries = {
  size: "medium",
  quality: "quick",
  seconds: "8",
  rate: "25",
  cycles: "0",
  views: [],
  withMarks: true, // as on the screen
};
const noFaults: Faults = { seconds: "", cycles: "", form: "" };

function entriesFor(kind: VideoFormProps["kind"], session: ViewerSession): VideoEntries {
  if (kind === "around") return { ...firstEntries, seconds: "20" };
  if (kind !== "phases") return firstEntries;
  const { phases, rate } = session.phases;
  const { cycles, seconds } = usualCycles(phases.value.length, rate.value);
  return { ...firstEntries, cycles: String(cycles), seconds: String(seconds) };
}

/** The entries of the video form, their errors, and the resulting order. */
export function useVideoForm({ session, kind, onExport }: VideoFormProps) {
  const app = useApp();
  const [entries, setEntries] = useState(() => entriesFor(kind, session));
  const [faults, setFaults] = useState(noFaults);
  const [preparing, setPreparing] = useState(false);
  const here = useIsMounted();
  const set = (part: Partial<VideoEntries>) => setEntries((before) => ({ ...before, ...part }));
  /** Sets an entry and clears its error. */
  const correct = (part: Partial<VideoEntries>) => {
    setFaults(noFaults);
    set(part);
  };
  /** Returns the scenes of the key views, or null if there are none. */
  const keysOf = async (scene: Scene, chosen: readonly KeyView[]): Promise<Scene[] | null> => {
    if (kind === "around") return session.guide.tour.videoScenes(scene);
    return kind === "tour" ? keyScenes(app.api.presets, chosen, session.editor, scene) : [scene];
  };
  const submit = async () => {
    const scene = session.editor.scene.value;
    const seconds = typedSeconds(entries.seconds, shortestOf(kind));
    const cycles = typedCycles(entries.cycles, fewestCycles(kind), mostCyclesOf(seconds, entries.rate));
    const chosen = entries.views.filter((view) => view.taken);
    setFaults(scene ? entryFaults(kind, seconds, cycles, chosen, entries.rate) : noFaults);
    if (!scene || seconds === null || cycles === null || hasWrongViews(kind, chosen)) return;
    setPreparing(true);
    try {
      const keys = await keysOf(scene, chosen);
      if (!keys) {
        setFaults({ ...noFaults, form: t.settings.view[session.guide.tour.fault.value ?? "unanswered"] });
        setPreparing(false);
        return;
      }
      const size = videoSize(session.viewport, videoSides[entries.size]);
      const error = videoErrors[entries.quality];
      const marks = entries.withMarks ? await fileMarksOf(session, size) : { unit: 1, items: [] };
      if (here.current)
        onExport(
          videoOrder({
            kind: kind === "around" ? "tour" : kind,
            keys,
            size,
            seconds,
            rate: Number(entries.rate),
            cycles,
            error,
            marks,
          }),
        );
    } catch (thrown) {
      setFaults({ ...noFaults, form: app.explain(thrown) });
    }
    setPreparing(false);
  };
  const setFault = (form: string) => setFaults((before) => ({ ...before, form }));
  return { entries, faults, preparing, set, correct, setFault, submit };
}

const hasWrongViews = (kind: VideoFormProps["kind"], chosen: readonly KeyView[]): boolean =>
  kind === "tour" && (chosen.length < 2 || chosen.length > mostKeyViews);

const shortestOf = (kind: VideoFormProps["kind"]): number => (kind === "around" ? shortestAroundS : 1);
/** A video whose camera stands still must play the phases. */
const fewestCycles = (kind: VideoFormProps["kind"]): number => (kind === "phases" ? 1 : 0);
/** A video needs at least one frame per cycle. */
const mostCyclesOf = (seconds: number | null, rate: string): number => (seconds ?? longestVideoS) * Number(rate);

function entryFaults(
  kind: VideoFormProps["kind"],
  seconds: number | null,
  cycles: number | null,
  chosen: readonly KeyView[],
  rate: string,
): Faults {
  if (seconds === null) return { ...noFaults, seconds: t.take.wrongSeconds(shortestOf(kind), longestVideoS) };
  if (cycles === null)
    return { ...noFaults, cycles: t.phases.wrongCycles(fewestCycles(kind), mostCyclesOf(seconds, rate)) };
  return hasWrongViews(kind, chosen) ? { ...noFaults, form: t.take.wrongViews(mostKeyViews) } : noFaults;
}

/**
 * Loads the scenes of the chosen views. The one without a preset is the current scene. All are
 * framed for the shape of the window.
 */
const keyScenes = (
  api: Pick<PresetsApi, "get">,
  chosen: readonly KeyView[],
  editor: Pick<SceneEditor, "framed">,
  scene: Scene,
): Promise<Scene[]> =>
  Promise.all(chosen.map(async ({ preset }) => (preset ? editor.framed(await sceneOfPreset(api, preset.id)) : scene)));

function useIsMounted() {
  const here = useRef(true);
  useEffect(
    () => () => {
      here.current = false;
    },
    [],
  );
  return here;
}
