import { useEffect, useRef, useState } from "preact/hooks";
import type { PresetsApi } from "../../../api/sharing";
import type { FileOrder } from "../../../protocol/file_messages";
import type { Scene } from "../../../protocol/messages";
import { t } from "../../../texts";
import { longestFilmS } from "../../../video/file_shot";
import type { ViewerSession } from "../../../video/viewer_session";
import { useApp } from "../../state";
import { sceneOfPreset } from "../preset_scene";
import {
  filmErrors,
  filmOrder,
  filmSides,
  filmSize,
  mostKeyViews,
  typedSeconds,
  type FilmQuality,
  type FilmSide,
  type KeyView,
} from "./film_size";

export interface FilmFormProps {
  readonly session: ViewerSession;
  readonly kind: "turntable" | "tour";
  readonly busy: boolean;
  readonly onExport: (order: FileOrder) => void;
}

/** What the person has entered so far. */
export interface FilmEntries {
  readonly size: FilmSide;
  readonly quality: FilmQuality;
  readonly seconds: string;
  readonly rate: string;
  readonly views: readonly KeyView[];
}

interface Faults {
  readonly seconds: string;
  readonly form: string;
}

const firstEntries: FilmEntries = { size: "medium", quality: "quick", seconds: "8", rate: "25", views: [] };
const noFaults: Faults = { seconds: "", form: "" };

/** The entries of the film form, their errors, and the resulting order. */
export function useFilmForm({ session, kind, onExport }: FilmFormProps) {
  const app = useApp();
  const [entries, setEntries] = useState(firstEntries);
  const [faults, setFaults] = useState(noFaults);
  const [preparing, setPreparing] = useState(false);
  const here = useIsMounted();
  const set = (part: Partial<FilmEntries>) => setEntries((before) => ({ ...before, ...part }));
  /** Sets an entry and clears its error. */
  const correct = (part: Partial<FilmEntries>) => {
    setFaults(noFaults);
    set(part);
  };
  const submit = async () => {
    const scene = session.editor.scene.value;
    const seconds = typedSeconds(entries.seconds);
    const chosen = entries.views.filter((view) => view.taken);
    setFaults(scene ? entryFaults(kind, seconds, chosen) : noFaults);
    if (!scene || seconds === null || hasWrongViews(kind, chosen)) return;
    setPreparing(true);
    try {
      const keys = kind === "tour" ? await keyScenes(app.api.presets, chosen, scene) : [scene];
      const size = filmSize(session.viewport, filmSides[entries.size]);
      const error = filmErrors[entries.quality];
      if (here.current) onExport(filmOrder({ kind, keys, size, seconds, rate: Number(entries.rate), error }));
    } catch (thrown) {
      setFaults({ seconds: "", form: app.explain(thrown) });
    }
    setPreparing(false);
  };
  const setFault = (form: string) => setFaults((before) => ({ ...before, form }));
  return { entries, faults, preparing, set, correct, setFault, submit };
}

const hasWrongViews = (kind: FilmFormProps["kind"], chosen: readonly KeyView[]): boolean =>
  kind === "tour" && (chosen.length < 2 || chosen.length > mostKeyViews);

function entryFaults(kind: FilmFormProps["kind"], seconds: number | null, chosen: readonly KeyView[]): Faults {
  if (seconds === null) return { seconds: t.take.wrongSeconds(longestFilmS), form: "" };
  return hasWrongViews(kind, chosen) ? { seconds: "", form: t.take.wrongViews(mostKeyViews) } : noFaults;
}

/** The scenes of the chosen views. The one without a preset is the current scene. */
const keyScenes = (api: Pick<PresetsApi, "get">, chosen: readonly KeyView[], scene: Scene): Promise<Scene[]> =>
  Promise.all(chosen.map(async ({ preset }) => (preset ? await sceneOfPreset(api, preset.id) : scene)));

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
