import { useMemo } from "preact/hooks";
import { fusedPlace } from "../../live/place";
import { t } from "../../texts";
import { Loading } from "../loading";
import { titleOf } from "../scan_card";
import { useApp } from "../state";
import { Viewer } from "../viewer/viewer";
import { AlignPanel } from "./align_panel";
import { CompareHeader } from "./compare_header";
import { OverlayPanel } from "./overlay_panel";
import type { TwoScans } from "./side_by_side";
import { useAlignment } from "./use_alignment";

/** A scan with a second one over it, once it is known how both lie in one space. */
export function OneOverTheOther({ first, second, sets }: TwoScans) {
  const app = useApp();
  const alignment = useAlignment(first, second);
  const { found, fault } = alignment;
  // Another alignment needs another session.
  const motion = found?.state === "ready" ? JSON.stringify(found.matrix) : null;
  // eslint-disable-next-line react-hooks/exhaustive-deps -- see above
  const place = useMemo(() => fusedPlace(app.api, first, second), [app, first, second, motion]);
  const [title, otherTitle] = [sets[0] ? titleOf(sets[0]) : "", sets[1] ? titleOf(sets[1]) : ""];
  const heading = title && otherTitle ? t.compare.title(title, otherTitle) : "";
  if (motion !== null)
    return (
      <Viewer
        key={motion}
        place={place}
        title={heading}
        set={sets[0]}
        fused={(session) => (
          <OverlayPanel session={session} first={first} second={second} title={otherTitle} alignment={alignment} />
        )}
      />
    );
  return (
    <div class="viewer compare">
      <CompareHeader title={heading} first={first} second={second} over>
        {null}
      </CompareHeader>
      <main class="compare-align">
        <section class="glass compare-align-box" aria-labelledby="align-title">
          <h2 id="align-title">{t.compare.align.title}</h2>
          {found || fault ? <AlignPanel task={alignment} /> : <Loading />}
        </section>
      </main>
      <footer class="not-medical">{t.viewer.notMedical}</footer>
    </div>
  );
}
