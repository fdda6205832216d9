import { useEffect, useMemo, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { forgetView } from "../../video/view_memory";
import { ownPlace, type Place } from "../../live/place";
import { randomKey } from "../../api/random_key";
import { sceneFromJson, sceneToJson, type Scene } from "../../protocol/messages";
import { tab } from "../../storage";
import type { Region, StepKind, View } from "../../studies/definition";
import { withRegion } from "../../studies/region";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Choice } from "../choice";
import { Loading } from "../loading";
import { InPicture } from "../picture/in_picture";
import { PointPicker } from "../picture/point_picker";
import { titleOf } from "../scan_card";
import { PageTitle } from "../shell";
import { useApp } from "../state";
import { OrientationCube } from "../viewer/orientation_cube";
import { LivePicture } from "./live_picture";
import { LookFields } from "./look_fields";
import { MayChangeFields } from "./may_change_fields";
import { RegionFields } from "./region_fields";
import { useViewScans } from "./use_view_scans";
import type { ViewSettings } from "./view_settings";

export interface ViewEditorProps {
  /** The view to change, or null for a new one. */
  readonly view: View | null;
  readonly kind: StepKind;
  readonly onUse: (view: View) => void;
  readonly onCancel: () => void;
}

/** Lets the researcher choose the picture of a step in a live view of the scan. */
export function ViewEditor({ view, kind, onUse, onCancel }: ViewEditorProps) {
  const scans = useViewScans();
  const [chosen, setChosen] = useState<string | null>(view?.data_set_id ?? null);
  const text = t.studies.editor;
  const scan = scans?.find(({ id }) => id === chosen) ?? scans?.[0] ?? null;
  return (
    <div class="page study-editor">
      <PageTitle text={text.title} />
      {scans === null ? <Loading /> : null}
      {scans?.length === 0 ? <p role="status">{text.scanNone}</p> : null}
      {scans && scan ? (
        <ScanView
          key={scan.id}
          scan={scan}
          scans={scans}
          choose={setChosen}
          view={view?.data_set_id === scan.id ? view : null}
          kind={kind}
          onUse={onUse}
          onCancel={onCancel}
        />
      ) : (
        <p>
          <button type="button" class="button" onClick={onCancel}>
            {t.cancel}
          </button>
        </p>
      )}
    </div>
  );
}

interface ScanViewProps extends ViewEditorProps {
  readonly scan: DataSet;
  readonly scans: readonly DataSet[];
  readonly choose: (id: string) => void;
}

function ScanView({ scan, scans, choose, view, kind, onUse, onCancel }: ScanViewProps) {
  const { place, again } = useComposerPlace(scan.id, view);
  const [session, setSession] = useState<ViewerSession | null>(null);
  const [settings, set] = useState<ViewSettings>(() => settingsOf(view, kind));
  const picture = useMemo(() => new InPicture(), []);
  useShownRegion(session, settings.region);
  const text = t.studies.editor;
  const use = () => {
    const scene = session?.editor.toSave();
    if (scene) onUse(viewOf(scan.id, scene, settings));
  };
  return (
    <div class="study-live">
      <LivePicture key={again.count} place={place} turns onSession={setSession} onAgain={again.begin}>
        {session ? <OrientationCube session={session} leads /> : null}
        <PointPicker picture={picture} />
      </LivePicture>
      <section class="study-panel">
        <Choice
          label={text.scan}
          value={scan.id}
          options={scans.map((one) => [one.id, titleOf(one)] as const)}
          onChoose={choose}
        />
        {session ? <LookFields session={session} scan={scan} settings={settings} set={set} /> : null}
        <p class="hint">{t.takePart.hint}</p>
        <MayChangeFields settings={settings} set={set} kind={kind} />
        {session ? <RegionFields session={session} picture={picture} settings={settings} set={set} /> : null}
        <div class="study-choices">
          <button type="button" class="button" onClick={onCancel}>
            {t.cancel}
          </button>
          <button
            type="button"
            class="button button-main"
            disabled={session?.pictures.picture.value == null}
            onClick={use}
          >
            {text.use}
          </button>
        </div>
      </section>
    </div>
  );
}

/** A first view that the researcher chose would lead participants to it, so a choice of a view begins at random. */
const firstStart = (kind: StepKind): View["start"] =>
  kind === "viewpoint" || kind === "latency" ? "random" : "preset";

const settingsOf = (view: View | null, kind: StepKind): ViewSettings => ({
  preset: view?.preset ?? "",
  mayChange: view?.may_change ?? ["camera"],
  start: kind === "latency" ? "random" : (view?.start ?? firstStart(kind)),
  region: view?.region ?? null,
});

const viewOf = (dataSetId: string, scene: Scene, { preset, mayChange, start, region }: ViewSettings): View => ({
  data_set_id: dataSetId,
  scene: JSON.parse(sceneToJson(withRegion(scene, region))) as object,
  preset: preset || t.studies.editor.custom,
  may_change: mayChange,
  start,
  ...(region ? { region } : {}),
});

/** The place of the composer's picture, which begins with the saved view and remembers nothing. */
export function useComposerPlace(dataSetId: string, view: View | null) {
  const { api } = useApp();
  const [count, setCount] = useState(0);
  const place = useMemo((): Place => {
    const saved = view ? sceneFromJson(JSON.stringify(view.scene)) : null;
    const key = `study.${randomKey()}`;
    const own = ownPlace(api, dataSetId);
    return {
      ...own,
      key,
      leave: (id) => {
        forgetView(tab, key);
        own.leave(id);
      },
      ...(saved ? { firstScene: () => saved } : {}),
    };
    // eslint-disable-next-line react-hooks/exhaustive-deps -- another count begins a new session
  }, [api, dataSetId, view, count]);
  return { place, again: { count, begin: () => setCount(count + 1) } };
}

/** Shows the region in the picture, also after another look has replaced the scene. */
function useShownRegion(session: ViewerSession | null, region: Region | null): void {
  const scene = session?.editor.scene.value ?? null;
  useEffect(() => {
    if (session && scene && withRegion(scene, region) !== scene)
      session.editor.change("region", (now) => withRegion(now, region));
  }, [session, scene, region]);
}
