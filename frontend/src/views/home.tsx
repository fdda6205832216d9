import { useEffect } from "preact/hooks";
import type { DataSet } from "../api/types";
import { t } from "../texts";
import { Art } from "./account_frame";
import { lookOf } from "./looks";
import { Link } from "./router";
import { KindChip, titleOf } from "./scan_card";
import { Notice, PageTitle } from "./shell";
import { useApp } from "./state";
import { useThumbnail } from "./thumbnail";
import { useSamples } from "./use_samples";

/** The front page for people who are not signed in: what Diaphane is and is not, and a link to a sample. */
export function Home() {
  const samples = useSamples();
  const sample = samples?.[0] ?? null;
  const text = t.home;
  const app = useApp();
  useEffect(() => () => void (app.signOutNotice.value = ""), [app]);
  return (
    <div class="home">
      <section class="home-text">
        {app.signOutNotice.value ? <Notice kind="good">{app.signOutNotice.value}</Notice> : null}
        <PageTitle text={text.title} />
        <p class="lead">{text.what}</p>
        <p class="lead">{text.privacy}</p>
        <p class="home-ways">
          {sample ? (
            <Link href={`/sample/${sample.id}`} class="button button-main">
              {text.sample}
            </Link>
          ) : null}
          <Link href="/sign-up" class={`button${sample ? "" : " button-main"}`}>
            {t.account.signUp}
          </Link>
        </p>
        <p class="home-notice">{text.notMedical}</p>
      </section>
      <div class="home-pictures">
        {sample ? <SamplePicture sample={sample} /> : <HomeArt />}
        <MoreSamples samples={samples?.slice(1, mostSamples) ?? []} />
      </div>
    </div>
  );
}

/** How many samples the front page shows. The gallery has all of them. */
const mostSamples = 4;

/** The other samples, each as a small picture with its title. */
function MoreSamples({ samples }: { readonly samples: readonly DataSet[] }) {
  if (samples.length === 0) return null;
  return (
    <ul class="home-samples" aria-label={t.home.others}>
      {samples.map((sample) => (
        <MoreSample key={sample.id} sample={sample} />
      ))}
    </ul>
  );
}

function MoreSample({ sample }: { readonly sample: DataSet }) {
  const { url, missing } = useThumbnail(sample.id, lookOf(sample), true);
  return (
    <li>
      <Link href={`/sample/${sample.id}`} class="home-sample">
        <span class={`home-sample-picture${url || missing ? "" : " card-working"}`} aria-hidden="true">
          {url ? <img src={url} alt="" width={320} height={320} /> : <Art />}
        </span>
        <span>
          {titleOf(sample)} <KindChip set={sample} />
        </span>
      </Link>
    </li>
  );
}

function SamplePicture({ sample }: { readonly sample: DataSet }) {
  const { url } = useThumbnail(sample.id, lookOf(sample), true);
  if (url === null) return <HomeArt />;
  return (
    <figure>
      <Link href={`/sample/${sample.id}`} class="home-picture" label={t.home.open(titleOf(sample))}>
        <img src={url} alt={t.scans.picture(titleOf(sample))} width={320} height={320} />
      </Link>
    </figure>
  );
}

function HomeArt() {
  return (
    <div class="home-picture" aria-hidden="true">
      <Art />
    </div>
  );
}
