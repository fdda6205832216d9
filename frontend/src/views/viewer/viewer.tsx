import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import type { Region } from "../../cut/region";
import type { KeyCommand } from "../../input/keys";
import { ownPlace, type Place } from "../../live/place";
import { roleOf } from "../../live/role";
import { isOver, isVisitOver } from "../../protocol/connection";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { OpenLibrary } from "../marks/open_library";
import { InPicture } from "../picture/in_picture";
import { titleOf } from "../scan_card";
import { useApp } from "../state";
import { LinkedView } from "./export/linked_view";
import { ShotLine, useShot, type Shot } from "./export/shot";
import { LiveLine, RaisedHands } from "./live_line";
import { obeyCommand } from "./obey_command";
import { PictureTimeLine } from "./picture_time";
import { RecordedInteraction } from "./recording";
import { CurvedSliceView, SlicesLine } from "./slices/slice_views";
import { StatusLine } from "./status_line";
import { TourLine } from "./tour_line";
import { useKeyCommands } from "./use_key_commands";
import { useViewerSession } from "./use_viewer_session";
import { HiddenTable } from "./treatment";
import { ViewerDialogs, type OpenDialog } from "./viewer_dialogs";
import { ViewerHeader, type ViewerHeaderProps } from "./viewer_header";
import { ViewerPanels } from "./viewer_panels";
import { ViewerStage } from "./viewer_stage";
import type { Visitor } from "./visitor";
import { WantedPreset } from "./wanted_preset";

/** The viewer for a scan that the user's account may open. */
export function OwnViewer({ dataSetId }: { readonly dataSetId: string }) {
  const app = useApp();
  const [set, setSet] = useState<DataSet | null>(null);
  const place = useMemo(() => ownPlace(app.api, dataSetId), [app, dataSetId]);
  useEffect(() => {
    app.api.dataSet(dataSetId).then(setSet, () => undefined); // the stream reports the error
  }, [app, dataSetId]);
  return <Viewer place={place} title={set ? titleOf(set) : ""} set={set} onChange={setSet} />;
}

export interface ViewerProps {
  readonly place: Place;
  readonly title: string;
  /** The facts about the scan, which only users with an account get. */
  readonly set?: DataSet | null;
  /** Set if the viewer is a visitor. */
  readonly visitor?: Visitor;
  /** Set if a second scan is shown over this one: the controls of both. */
  readonly fused?: (session: ViewerSession) => ComponentChildren;
  readonly onChange?: (set: DataSet) => void;
  /** Set if the scan is to be cut. Called with the region to keep and the hash of the volume that it belongs to. */
  readonly onCut?: (region: Region, volumeHash: string) => void;
}

const ignore = () => undefined;

export function Viewer({ place, title, set = null, onChange = ignore, onCut, visitor, fused }: ViewerProps) {
  const page = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const { session, fault } = useViewerSession(place, canvas);
  const [open, setOpen] = useState<OpenDialog | null>(null);
  // eslint-disable-next-line react-hooks/exhaustive-deps -- another place begins with fresh handles in the picture
  const picture = useMemo(() => new InPicture(), [place]);
  const shot = useShot(place);
  const isEnded = session !== null && isOver(session.connection.value);
  const role = roleOf(isEnded ? null : (session?.audience.value ?? null));
  const own = place.data_set_id !== null;
  const cutting = onCut !== undefined;
  const cut = onCut && place.data_set_id !== null ? { dataSetId: place.data_set_id, onConfirm: onCut } : null;
  const focusPicture = () => canvas.current?.focus();
  const obey = (command: KeyCommand) => {
    if (session) obeyCommand(command, { session, page: page.current, slices: !cutting, open: setOpen });
  };
  useKeyCommands(obey);
  useEffect(() => {
    document.title = `${title || t.titles.view} · ${t.name}`;
  }, [title]);

  const common = { session, role, own, set };
  return (
    <div
      class="viewer"
      ref={page}
      data-slices={session?.slices.open.value ? session.slices.view.value : undefined}
      data-curve={session?.slices.curveShown.value ? "" : undefined}
      data-following={session?.slices.following.value ? "" : undefined}
      data-visit={session && isVisitOver(session.connection.value) ? "over" : undefined}
    >
      <ViewerStage canvas={canvas} session={session} role={role} picture={picture} cutting={cutting} />
      <ViewerHeader {...common} {...{ title, visitor, cutting, obey }} fused={fused !== undefined} open={setOpen} />
      <footer class="not-medical">{t.viewer.notMedical}</footer>
      {session ? <SlicesLine session={session} /> : null}
      {session ? <CurvedSliceView session={session} /> : null}
      <Status {...common} {...{ visitor, fault, shot, cutting, focusPicture }} film={() => setOpen("film")} />
      {session && role.follows ? <LiveLine session={session} role={role} owner={own} /> : null}
      {session ? (
        <ViewerPanels session={session} role={role} picture={picture} cut={cut} focusPicture={focusPicture} />
      ) : null}
      {session && role.presents && fused ? fused(session) : null}
      {session && own && role.presents && !cutting ? (
        <>
          <WantedPreset session={session} />
          <LinkedView session={session} />
        </>
      ) : null}
      <ViewerDialogs {...common} open={open} close={() => setOpen(null)} onChange={onChange} shot={shot} />
      {own && session ? <RecordedInteraction session={session} /> : null}
      {session && place.savedMarks && !cutting ? (
        <OpenLibrary session={session} place={place} set={set} own={own} />
      ) : null}
    </div>
  );
}

type StatusProps = Pick<ViewerHeaderProps, "session" | "role" | "own" | "visitor" | "cutting"> & {
  readonly fault: string;
  readonly shot: Shot;
  readonly focusPicture: () => void;
  readonly film: () => void;
};

/** The state of the picture, with notes below it. */
function Status({ session, role, own, visitor, cutting, fault, shot, focusPicture, film }: StatusProps) {
  return (
    <StatusLine session={session} fault={fault} visitor={visitor}>
      {own ? <PictureTimeLine onHide={focusPicture} /> : null}
      <ShotLine shot={shot} />
      {session && role.presents && role.others > 0 ? <RaisedHands session={session} role={role} /> : null}
      {session && !cutting ? <TourLine session={session} role={role} onHide={focusPicture} onVideo={film} /> : null}
      {session && !cutting ? <HiddenTable session={session} presents={role.presents} /> : null}
    </StatusLine>
  );
}
