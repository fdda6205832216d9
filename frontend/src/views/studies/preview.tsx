import { useEffect, useMemo, useState } from "preact/hooks";
import { randomKey } from "../../api/random_key";
import type { JoinedStudy } from "../../api/studies";
import { after } from "../../live/paced";
import { keeping } from "../../storage";
import { Participation } from "../../studies/participation";
import { t } from "../../texts";
import { Loading } from "../loading";
import { Link, navigate } from "../router";
import { Notice, PageTitle } from "../shell";
import { useApp } from "../state";
import { StudyMessage } from "./study_frame";
import { StudySteps } from "./study_steps";

/** Shows a study to its researcher as participants get it. The answers are not counted, and nothing is remembered. */
export function PreviewStudy({ studyId }: { readonly studyId: string }) {
  const app = useApp();
  const [key] = useState(() => randomKey() + randomKey());
  const [joined, setJoined] = useState<JoinedStudy | null>(null);
  const [fault, setFault] = useState("");
  const [ended, setEnded] = useState(false);
  useEffect(() => {
    app.api.studies.preview(studyId, key).then(setJoined, (thrown: unknown) => setFault(app.explain(thrown)));
  }, [app, studyId, key]);
  const participation = useMemo(
    () => joined && new Participation(app.api.studies, key, joined, false, memory(), after),
    [app, key, joined],
  );
  const path = `/studies/${studyId}`;
  if (participation && !ended)
    return <StudySteps participation={participation} end={() => setEnded(true)} leave={() => navigate(path)} />;
  return (
    <StudyMessage>
      <PageTitle text={ended ? t.takePart.thanks : t.studies.preview} />
      {fault ? <Notice kind="bad">{fault}</Notice> : ended ? <p>{t.takePart.preview}</p> : <Loading />}
      <p>
        <Link href={path} class="button">
          {t.takePart.previewEnd}
        </Link>
      </p>
    </StudyMessage>
  );
}

/** Storage that lasts as long as the page. */
const memory = () =>
  keeping(() => {
    throw new Error("nothing is kept");
  });
