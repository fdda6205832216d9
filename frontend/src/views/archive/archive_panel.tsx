import { useEffect, useState } from "preact/hooks";
import type { Archive, ArchiveSearch, ArchiveStudy } from "../../api/archives";
import { t } from "../../texts";
import { Choice } from "../choice";
import { Field } from "../field";
import { fault, faultsOf, type Faults } from "../form";
import { Notice } from "../shell";
import { useApp } from "../state";
import { StudyList } from "./study_list";

/** Searches the hospital's archives. Nothing is shown to users without access, and without an archive. */
export function ArchivePanel() {
  const app = useApp();
  const [archives, setArchives] = useState<readonly Archive[]>([]);
  const [wrong, setWrong] = useState("");
  const may = app.me.value?.archive_access === true;
  useEffect(() => {
    if (!may) return;
    app.api.archives.list().then(setArchives, () => setWrong(t.archive.away));
  }, [app, may]);
  const [first] = archives;
  if (!may || (!first && !wrong)) return null;
  return (
    <section class="panel archive" aria-labelledby="archive">
      <h2 id="archive">{t.archive.title}</h2>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {first ? <Search archives={archives} first={first} /> : null}
    </section>
  );
}

interface SearchProps {
  readonly archives: readonly Archive[];
  readonly first: Archive;
}

function Search({ archives, first }: SearchProps) {
  const search = useSearch(first.name);
  const text = t.archive;
  return (
    <>
      <p class="muted">{text.lead}</p>
      <form
        class="filter"
        role="search"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          void search.begin();
        }}
      >
        <SearchFields archives={archives} search={search} />
        <button type="submit" class="button button-main" disabled={search.busy} aria-busy={search.busy}>
          {search.busy ? text.searching : text.search}
        </button>
      </form>
      {search.faults.form ? <Notice kind="bad">{search.faults.form}</Notice> : null}
      {search.found ? <StudyList key={search.round} archive={search.searched} {...search.found} /> : null}
    </>
  );
}

interface SearchFieldsProps {
  readonly archives: readonly Archive[];
  readonly search: ReturnType<typeof useSearch>;
}

function SearchFields({ archives, search }: SearchFieldsProps) {
  const { fields, set, faults } = search;
  const text = t.archive;
  return (
    <>
      {archives.length > 1 ? (
        <Choice
          label={text.archive}
          value={search.archive}
          options={archives.map(({ name, title }) => [name, title])}
          onChoose={search.choose}
        />
      ) : null}
      <Field
        label={text.patientName}
        value={fields.patient_name}
        onInput={(value) => set({ patient_name: value })}
        most={64}
        verbatim
        autocomplete="off"
        placeholder={text.nameExample}
        {...fault(faults.patient_name)}
      />
      <Field
        label={text.patientId}
        value={fields.patient_id}
        onInput={(value) => set({ patient_id: value })}
        most={64}
        verbatim
        autocomplete="off"
        {...fault(faults.patient_id)}
      />
      <Field
        label={text.accession}
        value={fields.accession}
        onInput={(value) => set({ accession: value })}
        most={16}
        verbatim
        autocomplete="off"
        {...fault(faults.accession)}
      />
      <Field label={text.from} type="date" value={fields.from} onInput={(value) => set({ from: value })} />
      <Field label={text.until} type="date" value={fields.until} onInput={(value) => set({ until: value })} />
      <Choice
        label={text.modality}
        value={fields.modality}
        options={Object.entries(text.modalities)}
        onChoose={(value) => set({ modality: value as ArchiveSearch["modality"] })}
      />
    </>
  );
}

type Given = "patient_name" | "patient_id" | "accession";
const none: ArchiveSearch = { patient_name: "", patient_id: "", accession: "", modality: "", from: "", until: "" };

/** The fields of the search and what it found, which only the page keeps. */
function useSearch(first: string) {
  const app = useApp();
  const [archive, setArchive] = useState(first);
  const [searched, setSearched] = useState(first);
  const [fields, setFields] = useState(none);
  const [faults, setFaults] = useState<Faults<Given>>({});
  const [busy, setBusy] = useState(false);
  const [round, setRound] = useState(0);
  const [found, setFound] = useState<{ readonly items: readonly ArchiveStudy[]; readonly more: boolean } | null>(null);
  const set = (change: Partial<ArchiveSearch>) => setFields({ ...fields, ...change });
  const begin = async () => {
    if (!fields.patient_name.trim() && !fields.patient_id.trim() && !fields.accession.trim() && !fields.from) {
      setFaults({ patient_name: t.archive.needed });
      return;
    }
    setBusy(true);
    setFaults({});
    try {
      setFound(await app.api.archives.search(archive, fields));
      setSearched(archive);
      setRound(round + 1);
    } catch (thrown) {
      setFound(null);
      setFaults(faultsOf(thrown, ["patient_name", "patient_id", "accession"], (what) => app.explain(what)));
    } finally {
      setBusy(false);
    }
  };
  return { archive, choose: setArchive, searched, fields, set, faults, busy, found, round, begin };
}
