import { useState } from "preact/hooks";
import type { Ending } from "../../studies/participation";
import { t } from "../../texts";
import { CopyField } from "../copy_field";
import { withdrawal } from "../routes";
import { PageTitle } from "../shell";
import { StudyMessage } from "./study_frame";

export interface EndPageProps {
  readonly ending: Ending;
  readonly participant: string;
  /** Tries to continue, which succeeds if a closed study is open again. */
  readonly again?: () => void;
}

/** The end of a participation. Unless the answers are deleted, it shows the link that deletes them. */
export function EndPage({ ending, participant, again }: EndPageProps) {
  const [told, setTold] = useState("");
  const text = t.takePart;
  const [title, words] = {
    finished: [text.thanks, text.thanksText],
    kept: [text.keptTitle, text.keptText],
    over: [text.overTitle, text.overText],
    gone: [text.endedTitle, text.endedText],
    deleted: [text.deletedTitle, text.deletedText],
  }[ending] as [string, string];
  const link = `${location.origin}/study#${withdrawal}${participant}`;
  const copy = () => {
    navigator.clipboard.writeText(link).then(
      () => setTold(text.copied),
      () => setTold(text.copyFailed),
    );
  };
  return (
    <StudyMessage>
      <PageTitle text={title} />
      <p class="lead">{words}</p>
      {ending === "over" && again ? (
        <p>
          <button type="button" class="button" onClick={again}>
            {text.overAgain}
          </button>
        </p>
      ) : null}
      {ending === "deleted" || ending === "gone" ? null : (
        <section class="share-part" aria-label={text.withdrawLink}>
          <h2>{text.withdrawLink}</h2>
          <p>{text.withdrawHint}</p>
          <CopyField value={link} label={text.withdrawLink} button={text.copy} onCopy={copy} />
          <p class="muted" role="status">
            {told}
          </p>
        </section>
      )}
    </StudyMessage>
  );
}
