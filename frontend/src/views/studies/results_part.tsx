import { useEffect, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import {
  studyExportPath,
  type AdoptedComfort,
  type Analysis,
  type AnalysisFigure,
  type AnalysisSection,
  type Study,
} from "../../api/studies";
import { setAdoptedComfort } from "../../scene/comfort";
import { textIn } from "../../studies/definition";
import { language, t } from "../../texts";
import { UserError, useApp } from "../state";
import { Table } from "../table";
import { TourAdoption } from "./tour_adoption";
import { useAct } from "../use_act";

/** The answers as files, and their analysis. */
export function ResultsPart({ study }: { readonly study: Study }) {
  const { app, act, busy, outcome } = useAct();
  const [analysis, setAnalysis] = useState<Analysis | null>(null);
  const text = t.studies;
  const analyse = () =>
    act(async () => {
      try {
        const found = await app.api.studies.analysis(study.id, language.value);
        setAnalysis(found);
        return found.sections.length === 0 ? text.analysisNone : "";
      } catch (thrown) {
        const kind = thrown instanceof ApiProblem && thrown.status === 503 ? thrown.kind : "";
        if (kind === "unavailable") throw new UserError(text.analysisMissing);
        throw kind === "busy" ? new UserError(text.analysisBusy) : thrown;
      }
    });
  return (
    <section class="share-part">
      <h2>{text.results}</h2>
      <div class="study-choices">
        <a class="button" href={studyExportPath(study.id, "json")} download="study.json">
          {text.exportJson}
        </a>
        <a class="button" href={studyExportPath(study.id, "csv")} download="study.zip">
          {text.exportCsv}
        </a>
        <button type="button" class="button" disabled={busy} onClick={analyse}>
          {text.analyse}
        </button>
      </div>
      {busy ? (
        <p class="muted" role="status">
          {text.analysing}
        </p>
      ) : null}
      {outcome}
      {analysis?.sections.map((section) => (
        <Section key={section.id} section={section} />
      ))}
      {analysis ? <TourAdoption study={study} analysis={analysis} /> : null}
      {app.me.value?.administrator ? (
        <Adoption study={study} found={analysis?.adoptable.comfort !== null && analysis !== null} />
      ) : null}
    </section>
  );
}

function Section({ section }: { readonly section: AnalysisSection }) {
  return (
    <section class="study-analysis">
      <h3>{section.title}</h3>
      {section.notes.map((note, i) => (
        <p key={i}>{note}</p>
      ))}
      {section.tables.map((table) => (
        <div key={table.title}>
          <h4>{table.title}</h4>
          <Table
            label={table.title}
            heads={table.columns}
            rows={table.rows.map((cells, i) => ({ key: String(i), cells }))}
          />
        </div>
      ))}
      {section.figures.map((figure) => (
        <Figure key={figure.id} figure={figure} />
      ))}
    </section>
  );
}

/** A figure as a picture. In an image, an SVG file runs no scripts and loads nothing. */
function Figure({ figure }: { readonly figure: AnalysisFigure }) {
  const [url, setUrl] = useState("");
  useEffect(() => {
    const made = URL.createObjectURL(new Blob([figure.svg], { type: "image/svg+xml" }));
    setUrl(made);
    return () => URL.revokeObjectURL(made);
  }, [figure.svg]);
  return (
    <figure class="study-figure">
      {url ? <img src={url} alt={figure.title} /> : null}
      <figcaption>{figure.title}</figcaption>
    </figure>
  );
}

/** Lets an administrator use the colours of a study for the comfort slider of all users. */
function Adoption({ study, found }: { readonly study: Study; readonly found: boolean }) {
  const { api } = useApp();
  const { app, act, busy, outcome } = useAct();
  const [adopted, setAdopted] = useState<AdoptedComfort | null>(null);
  const text = t.studies;
  const read = async () => {
    const { comfort } = await api.studies.perception();
    setAdopted(comfort);
    setAdoptedComfort(comfort);
  };
  useEffect(() => {
    void read().catch(() => undefined);
    // eslint-disable-next-line react-hooks/exhaustive-deps -- read once, and after each change
  }, [api]);
  const change = (work: () => Promise<void>, told: string) =>
    act(async () => {
      await work();
      await read();
      return told;
    });
  if (!found && !adopted) return null;
  return (
    <div class="study-adoption">
      {adopted ? <p>{text.adoptedFrom(textIn(adopted.title, language.value).text, adopted.participants)}</p> : null}
      {found ? <p class="muted">{text.adoptText}</p> : null}
      <div class="study-choices">
        {found ? (
          <button
            type="button"
            class="button"
            disabled={busy}
            onClick={() => change(() => app.api.studies.adoptComfort(study.id), text.adopted)}
          >
            {text.adopt}
          </button>
        ) : null}
        {adopted ? (
          <button
            type="button"
            class="button"
            disabled={busy}
            onClick={() => change(() => app.api.studies.dropComfort(), text.dropped)}
          >
            {text.drop}
          </button>
        ) : null}
      </div>
      {outcome}
    </div>
  );
}
