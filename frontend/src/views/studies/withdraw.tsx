import { useState } from "preact/hooks";
import { t } from "../../texts";
import { PageTitle } from "../shell";
import { useAct } from "../use_act";
import { EndPage } from "./end_page";
import { StudyMessage } from "./study_frame";

/** The page of the link with which a participant deletes their answers. */
export function Withdraw({ participant }: { readonly participant: string }) {
  const { app, act, busy, outcome } = useAct();
  const [deleted, setDeleted] = useState(false);
  const text = t.takePart;
  if (deleted) return <EndPage ending="deleted" participant={participant} />;
  return (
    <StudyMessage>
      <PageTitle text={text.withdrawTitle} />
      <p class="lead">{text.withdrawText}</p>
      {outcome}
      <p>
        <button
          type="button"
          class="button button-danger"
          disabled={busy}
          onClick={() =>
            act(async () => {
              await app.api.studies.withdraw(participant);
              setDeleted(true);
              return "";
            })
          }
        >
          {text.withdrawYes}
        </button>
      </p>
    </StudyMessage>
  );
}
