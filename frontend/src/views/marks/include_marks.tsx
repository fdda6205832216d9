import { annotationsOf } from "../../marks/library";
import type { Annotations } from "../../protocol/mark_messages";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Switch } from "../viewer/settings/controls";

/** Returns the shown marks and the measurements of this viewer. */
export const shownAnnotations = (session: ViewerSession): Annotations => {
  const all = annotationsOf(session, () => true);
  return session.marks.shown.value ? all : { ...all, marks: [] };
};

export interface IncludeMarksProps {
  readonly session: ViewerSession;
  readonly on: boolean;
  readonly change: (on: boolean) => void;
}

/** The option to include marks and measurements in a link or a preset. Absent if there are none. */
export function IncludeMarks({ session, on, change }: IncludeMarksProps) {
  const { marks, measures } = shownAnnotations(session);
  if (marks.length + measures.length === 0) return null;
  return (
    <>
      <Switch label={t.marks.include(marks.length, measures.length)} on={on} change={change} />
      {on && marks.length > 0 ? <p class="field-hint">{t.marks.includeHint}</p> : null}
    </>
  );
}
