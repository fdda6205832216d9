import { useState } from "preact/hooks";
import { setShowsTable, showsTable } from "../../scene/cuts";
import { local } from "../../storage";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Icon } from "../icons";
import { sceneEdits } from "./settings/scene_edits";

const key = "diaphane.hiddenTable";

interface Props {
  readonly session: ViewerSession;
}

/**
 * Says that the picture leaves out a table or headrest, and offers to show it. Once closed, the
 * note stays closed.
 */
export function HiddenTable({ session, presents }: Props & { readonly presents: boolean }) {
  const [closed, setClosed] = useState(() => local.getItem(key) !== null);
  const scene = session.editor.scene.value;
  const hidden = session.treatment.value?.hasSupport && scene !== null && !showsTable(scene);
  if (!hidden || closed || session.pictures.picture.value === null) return null;
  const text = t.viewer.treatment;
  return (
    <p class="glass pill pill-note">
      <span data-said>{text.tableHidden}</span>
      {presents ? (
        <button
          type="button"
          class="button button-small"
          onClick={() => sceneEdits(session.editor).once("table", setShowsTable)(true)}
        >
          {text.showTable}
        </button>
      ) : null}
      <button
        type="button"
        class="icon-button"
        aria-label={text.close}
        title={text.close}
        onClick={() => {
          local.setItem(key, "closed");
          setClosed(true);
        }}
      >
        <Icon name="close" />
      </button>
    </p>
  );
}

/** How the picture differs from the stored scan, for the details of its quality. */
export function TreatmentFacts({ session }: Props) {
  const treatment = session.treatment.value;
  const scene = session.editor.scene.value;
  if (!treatment || !scene) return null;
  const text = t.viewer.treatment;
  const between = treatment.slicesPerStored - 1;
  return (
    <>
      {between > 0 ? (
        <p class="quality-help" data-fact="interpolated">
          {text.interpolated(between)}
        </p>
      ) : null}
      {treatment.hasSupport && !showsTable(scene) ? (
        <p class="quality-help" data-fact="table">
          {text.tableHidden}
        </p>
      ) : null}
    </>
  );
}
