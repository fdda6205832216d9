import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { DataSet } from "../../api/types";
import type { KeyCommand } from "../../input/keys";
import { comparedPlace } from "../../live/place";
import type { LinkMode } from "../../compare/picture_link";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { CloseButton, Dialog } from "../dialog";
import { IconButton } from "../icon_button";
import { titleOf } from "../scan_card";
import { useApp } from "../state";
import { PictureTimeLine } from "../viewer/picture_time";
import { useKeyCommands } from "../viewer/use_key_commands";
import { useViewerSession } from "../viewer/use_viewer_session";
import { AlignPanel } from "./align_panel";
import { CompareHeader } from "./compare_header";
import { ComparedScan } from "./compared_scan";
import { obeyInBoth } from "./obey_in_both";
import { useAlignment } from "./use_alignment";
import { useLink, type LinkChoice } from "./use_link";

export interface TwoScans {
  readonly first: string;
  readonly second: string;
  readonly sets: readonly [DataSet | null, DataSet | null];
}

/** Two scans in two pictures, whose cameras and looks are linked. */
export function SideBySide({ first, second, sets }: TwoScans) {
  const page = useRef<HTMLDivElement>(null);
  const [a, b] = [useSide(first, 0), useSide(second, 1)];
  const alignment = useAlignment(first, second);
  const [open, setOpen] = useState<"align" | "help" | null>(null);
  const motion = alignment.found?.scene_matrix ?? null;
  const link = useLink([a.session, b.session], motion);
  const obey = (command: KeyCommand) =>
    obeyInBoth(command, {
      sessions: [a.session, b.session],
      active: activeSide(),
      linked: link.mode !== "off",
      page: page.current,
      help: () => setOpen("help"),
    });
  useKeyCommands(obey);
  const [title, otherTitle] = [titleOfSet(sets[0]), titleOfSet(sets[1])];
  const heading = title && otherTitle ? t.compare.title(title, otherTitle) : "";
  useEffect(() => {
    document.title = `${heading || t.compare.open} · ${t.name}`;
  }, [heading]);
  return (
    <div class="viewer compare" ref={page}>
      <CompareHeader title={heading} first={first} second={second}>
        <LinkSelect link={link} />
        <button
          type="button"
          class="button button-small"
          disabled={alignment.found === undefined}
          onClick={() => setOpen("align")}
        >
          {t.compare.align.open}
        </button>
        <IconButton icon="reset" label={t.viewer.reset} onClick={() => obey({ kind: "reset" })} />
        <IconButton class="tool-help" icon="help" label={t.viewer.help} onClick={() => setOpen("help")} />
      </CompareHeader>
      <main class="compare-panes">
        <ComparedScan {...a} set={sets[0]} side={0} />
        <ComparedScan {...b} set={sets[1]} side={1} />
      </main>
      <div class="compare-notes">
        <PictureTimeLine onHide={() => a.canvas.current?.focus()} />
      </div>
      <footer class="not-medical">{t.viewer.notMedical}</footer>
      {open === "align" ? (
        <Dialog title={t.compare.align.title} onClose={() => setOpen(null)}>
          <AlignPanel task={alignment} />
          <CloseButton onClick={() => setOpen(null)} />
        </Dialog>
      ) : null}
      {open === "help" ? (
        <Dialog title={t.viewer.help} onClose={() => setOpen(null)}>
          <p>{t.compare.help}</p>
          <CloseButton onClick={() => setOpen(null)} />
        </Dialog>
      ) : null}
    </div>
  );
}

const titleOfSet = (set: DataSet | null): string => (set ? titleOf(set) : "");

function useSide(dataSetId: string, side: number) {
  const app = useApp();
  const canvas = useRef<HTMLCanvasElement>(null);
  const place = useMemo(() => comparedPlace(app.api, dataSetId, side), [app, dataSetId, side]);
  const { session, fault }: { session: ViewerSession | null; fault: string } = useViewerSession(place, canvas);
  return { canvas, session, fault };
}

/** The side that has the focus. Keys act on the first picture if neither has it. */
const activeSide = (): 0 | 1 => (document.activeElement?.closest("[data-side='1'].compare-pane") ? 1 : 0);

function LinkSelect({ link }: { readonly link: LinkChoice }) {
  return (
    <select
      class="choice compare-link"
      aria-label={t.compare.link}
      title={t.compare.link}
      value={link.mode}
      onChange={(event) => link.choose(event.currentTarget.value as LinkMode)}
    >
      {link.modes.map((one) => (
        <option key={one} value={one}>
          {t.compare.links[one]}
        </option>
      ))}
    </select>
  );
}
