import type { StudyInfo } from "../../api/studies";
import { templates, textIn } from "../../studies/definition";
import { language, t } from "../../texts";
import { dayText } from "../format";
import { Loading } from "../loading";
import { MoreButton } from "../more_button";
import { Link } from "../router";
import { Notice, PageTitle } from "../shell";
import { useApp } from "../state";
import { Table } from "../table";
import { usePages } from "../use_pages";

/** The studies of a researcher, and the templates for a new one. */
export function Studies({ researcher }: { readonly researcher: boolean }) {
  const text = t.studies;
  return (
    <div class="page">
      <PageTitle text={text.title} />
      <p class="lead">{text.lead}</p>
      {researcher ? (
        <>
          <StudyList />
          <Templates />
        </>
      ) : (
        <Notice kind="info">{text.notResearcher}</Notice>
      )}
    </div>
  );
}

function StudyList() {
  const app = useApp();
  const { items, next, wrong, more } = usePages((cursor) => app.api.studies.list(cursor));
  const { heads, list, none } = t.studies;
  return (
    <section aria-label={list}>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <Loading /> : null}
      {items?.length === 0 ? <p role="status">{none}</p> : null}
      {items && items.length > 0 ? (
        <Table
          label={list}
          heads={[heads.title, heads.state, heads.participants, heads.ends]}
          rows={items.map((study) => ({ key: study.id, cells: cellsOf(study) }))}
        />
      ) : null}
      {next ? <MoreButton onClick={more} /> : null}
    </section>
  );
}

const titleOf = (study: StudyInfo): string => textIn(study.title, language.value).text || t.studies.untitled;

function cellsOf(study: StudyInfo) {
  return [
    <Link href={`/studies/${study.id}`}>{titleOf(study)}</Link>,
    <StateChip state={study.state} />,
    t.studies.joined(study.joined, study.places, study.finished),
    dayText(study.ends_at),
  ];
}

export function StateChip({ state }: Pick<StudyInfo, "state">) {
  return <span class={`chip${state === "open" ? " chip-good" : ""}`}>{t.studies.states[state]}</span>;
}

function Templates() {
  const text = t.studies;
  return (
    <section class="others">
      <h2>{text.newTitle}</h2>
      <ul class="study-templates">
        {templates.map((one) => (
          <li key={one}>
            <Link href={`/studies/${one}`} class="study-template">
              <strong>{text.templates[one].name}</strong>
              <span>{text.templates[one].text}</span>
            </Link>
          </li>
        ))}
      </ul>
    </section>
  );
}
