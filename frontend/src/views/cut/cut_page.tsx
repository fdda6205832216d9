import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import type { DataSet } from "../../api/types";
import { carryOutCut } from "../../cut/carry_out";
import { toBody, type Region } from "../../cut/region";
import { ownPlace } from "../../live/place";
import { t } from "../../texts";
import { problemText, serverSentence } from "../../texts/problem_text";
import { Link } from "../router";
import { titleOf } from "../scan_card";
import { Bar, Notice, PageTitle, Shell } from "../shell";
import { useApp } from "../state";
import { Viewer } from "../viewer/viewer";

type Stage = "choosing" | "working" | "done" | { readonly failed: string };

const pollIntervalMs = 500;

/** Lets the owner of a scan cut parts of it away permanently. */
export function CutPage({ dataSetId }: { readonly dataSetId: string }) {
  const app = useApp();
  const [set, setSet] = useState<DataSet | null>(null);
  // The key differs from the viewer's, so that the view used here is not remembered there.
  const place = useMemo(() => ({ ...ownPlace(app.api, dataSetId), key: `cut.${dataSetId}` }), [app, dataSetId]);
  useEffect(() => {
    app.api.dataSet(dataSetId).then(setSet, () => undefined);
  }, [app, dataSetId]);

  const { stage, carryOut } = useCut(dataSetId);
  if (stage === "choosing") {
    return <Viewer place={place} title={set ? titleOf(set) : ""} set={set} onCut={carryOut} />;
  }
  return (
    <Shell>
      <div class="page page-narrow">
        <CutOutcome stage={stage} dataSetId={dataSetId} shared={set?.shared ?? null} />
      </div>
    </Shell>
  );
}

/** Sends the cut to the server and follows it until it has succeeded or failed. */
function useCut(dataSetId: string) {
  const app = useApp();
  const [stage, setStage] = useState<Stage>("choosing");
  const left = useRef(false);
  useEffect(
    () => () => {
      left.current = true;
    },
    [],
  );
  const carryOut = (region: Region, volumeHash: string) => {
    setStage("working");
    const pause = () => new Promise<void>((resolve) => setTimeout(resolve, pollIntervalMs));
    const steps = { api: app.api.anonymise, pause, isOver: () => left.current };
    carryOutCut(steps, dataSetId, toBody(region), volumeHash).then(
      (outcome) => {
        if (outcome !== null) setStage(outcome === "done" ? "done" : { failed: serverSentence(outcome.problem, "") });
      },
      (thrown: unknown) => setStage({ failed: thrown instanceof ApiProblem ? problemText(thrown) : "" }),
    );
  };
  return { stage, carryOut };
}

interface CutOutcomeProps {
  readonly stage: Exclude<Stage, "choosing">;
  readonly dataSetId: string;
  readonly shared: DataSet["shared"];
}

function CutOutcome({ stage, dataSetId, shared }: CutOutcomeProps) {
  if (stage === "working")
    return (
      <>
        <PageTitle text={t.cut.title} />
        <p role="status">{t.cut.working}</p>
        <Bar value={null} label={t.cut.working} />
      </>
    );
  if (stage === "done")
    return (
      <>
        <PageTitle text={t.cut.doneTitle} />
        <Notice kind="good">
          {t.cut.done} {shared && shared.people + shared.links > 0 ? t.cut.doneShared : t.cut.donePrivate}
        </Notice>
        <p>
          <Link href={`/view/${dataSetId}`} class="button button-main">
            {t.cut.look}
          </Link>
        </p>
      </>
    );
  return (
    <>
      <PageTitle text={t.cut.title} />
      <Notice kind="bad">{stage.failed || t.cut.failed}</Notice>
      <p>
        <Link href="/scans" class="button">
          {t.cut.back}
        </Link>
      </p>
    </>
  );
}
