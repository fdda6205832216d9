import { useEffect, useMemo, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import type { DataSet } from "../../api/types";
import { to_body, type Region } from "../../cut/region";
import { own_place } from "../../live/place";
import { t } from "../../texts";
import { Link } from "../router";
import { title_of } from "../scan_card";
import { Bar, Notice, PageTitle, Shell } from "../shell";
import { useApp } from "../state";
import { Viewer } from "../viewer/viewer";

type Stage = "choosing" | "working" | "done" | { readonly failed: string };

const asked_every_ms = 500;

/** One's own scan is cut, by its owner, for good. */
export function CutPage({ data_set_id }: { readonly data_set_id: string }) {
  const app = useApp();
  const [set, set_set] = useState<DataSet | null>(null);
  const [stage, set_stage] = useState<Stage>("choosing");
  // Its view is not that of the viewer: what is tried here is not shown there.
  const place = useMemo(() => ({ ...own_place(app.api, data_set_id), key: `cut.${data_set_id}` }), [app, data_set_id]);
  useEffect(() => {
    app.api.data_set(data_set_id).then(set_set, () => undefined);
  }, [app, data_set_id]);

  const carry_out = (region: Region, volume_hash: string) => {
    set_stage("working");
    app.api.anonymise.cut(data_set_id, to_body(region), volume_hash).catch((thrown: unknown) => {
      set_stage({ failed: thrown instanceof ApiProblem ? thrown.detail : "" });
    });
  };
  useEffect(() => {
    if (stage !== "working") return;
    const ask = () => app.api.anonymise.look(data_set_id).then((now) => {
      if (now.state !== "ready") return;
      if (now.problem !== null) set_stage({ failed: now.problem });
      else if (now.anonymised_at !== (set?.anonymised_at ?? null)) set_stage("done");
    }, () => undefined); // it is asked again
    const timer = setInterval(() => void ask(), asked_every_ms);
    return () => clearInterval(timer);
  }, [stage, app, data_set_id, set]);

  if (stage === "choosing") {
    return <Viewer place={place} title={set ? title_of(set) : ""} set={set} onCut={carry_out} />;
  }
  return (
    <Shell>
      <div class="page page-narrow">
        {stage === "working" ? (
          <>
            <PageTitle text={t.cut.title} />
            <p role="status">{t.cut.working}</p>
            <Bar value={null} label={t.cut.working} />
          </>
        ) : stage === "done" ? (
          <>
            <PageTitle text={t.cut.done_title} />
            <Notice kind="good">{t.cut.done}</Notice>
            <p><Link href={`/view/${data_set_id}`} class="button button-main">{t.cut.look}</Link></p>
          </>
        ) : (
          <>
            <PageTitle text={t.cut.title} />
            <Notice kind="bad">{stage.failed || t.cut.failed}</Notice>
            <p><Link href="/scans" class="button">{t.cut.back}</Link></p>
          </>
        )}
      </div>
    </Shell>
  );
}
