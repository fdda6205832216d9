import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { Switch } from "../viewer/settings/controls";
import { marksInPicture } from "./in_pictures";

export interface DrawMarksProps {
  readonly session: ViewerSession;
  readonly video?: boolean;
  readonly on: boolean;
  readonly change: (on: boolean) => void;
}

/** The option to draw the marks into a saved picture or video. Absent if there are none. */
export function DrawMarks({ session, video = false, on, change }: DrawMarksProps) {
  const count = marksInPicture(session).length;
  if (count === 0) return null;
  const text = video ? t.marks.inVideo : t.marks.inPicture;
  return (
    <>
      <Switch label={text.include(count)} on={on} change={change} />
      <p class="field-hint">{text.hint}</p>
    </>
  );
}
