{{- define "diaphane.name" -}}
{{- if contains .Chart.Name .Release.Name }}{{ .Release.Name | trunc 40 | trimSuffix "-" }}{{ else }}{{ printf "%s-%s" .Release.Name .Chart.Name | trunc 40 | trimSuffix "-" }}{{ end -}}
{{- end -}}

{{- define "diaphane.image" -}}
{{- if .Values.image.digest }}{{ printf "%s@%s" .Values.image.repository .Values.image.digest }}{{ else }}{{ printf "%s:%s" .Values.image.repository (.Values.image.tag | default .Chart.AppVersion) }}{{ end -}}
{{- end -}}

{{/* Labels by which pods are chosen: never changed, and the only ones that pods have, so that another version of the chart alone replaces
     nobody. Called with a list of the root and the component. */}}
{{- define "diaphane.selector" -}}
app.kubernetes.io/name: diaphane
app.kubernetes.io/instance: {{ (index . 0).Release.Name }}
app.kubernetes.io/component: {{ index . 1 }}
{{- end -}}

{{- define "diaphane.labels" -}}
{{ include "diaphane.selector" . }}
app.kubernetes.io/version: {{ (index . 0).Chart.AppVersion | quote }}
app.kubernetes.io/part-of: diaphane
app.kubernetes.io/managed-by: {{ (index . 0).Release.Service }}
helm.sh/chart: {{ printf "%s-%s" (index . 0).Chart.Name (index . 0).Chart.Version }}
{{- end -}}

{{- define "diaphane.host" -}}
{{ .Values.publicUrl | trimPrefix "https://" | trimPrefix "http://" }}
{{- end -}}

{{- define "diaphane.redis" -}}
{{ if .Values.trial.enabled }}{{ include "diaphane.name" . }}-trial-redis:6379{{ else }}{{ required "redis.address (host:port) is missing; to evaluate Diaphane without your own Redis, set trial.enabled" .Values.redis.address }}{{ end -}}
{{- end -}}

{{- define "diaphane.redisUrl" -}}
{{ if .Values.redis.tls }}rediss://{{ end }}{{ include "diaphane.redis" . }}
{{- end -}}

{{/* The beginning of the names of the secrets with certificates, or nothing without TLS. */}}
{{- define "diaphane.innerTlsSecrets" -}}
{{- with .Values.innerTls -}}
{{- if .secretName }}{{ .secretName }}{{ else if .issuer.name }}{{ printf "%s-inner" (include "diaphane.name" $) }}{{ end -}}
{{- end -}}
{{- end -}}

{{/* The secret of a program, which is its own unless certificates have no roles. This and the next two are called with a list of the root and the
     program. */}}
{{- define "diaphane.innerTlsSecret" -}}
{{- include "diaphane.innerTlsSecrets" (index . 0) }}{{ if (index . 0).Values.innerTls.roles }}-{{ index . 1 }}{{ end -}}
{{- end -}}

{{/* How a program reaches others of ours and Redis; `innerTlsMounts` and `innerTlsVolumes` go with it. */}}
{{- define "diaphane.innerTls" -}}
{{- if include "diaphane.innerTlsSecrets" . }}
- {name: DIAPHANE_INNER_TLS_CA, value: /inner-tls/ca.crt}
- {name: DIAPHANE_INNER_TLS_CERTIFICATE, value: /inner-tls/tls.crt}
- {name: DIAPHANE_INNER_TLS_KEY, value: /inner-tls/tls.key}
- {name: DIAPHANE_INNER_TLS_NAME, value: {{ .Values.innerTls.serverName | quote }}}
{{- if not .Values.innerTls.roles }}
- {name: DIAPHANE_INNER_TLS_ROLES, value: "0"}
{{- end }}
{{- end }}
{{- if .Values.innerTls.plain }}
- {name: DIAPHANE_INNER_PLAIN, value: "1"}
{{- end }}
{{- end -}}

{{/* The whole directory: files mounted one by one would not be renewed. */}}
{{- define "diaphane.innerTlsMounts" -}}
{{- if include "diaphane.innerTlsSecrets" (index . 0) }}
- {name: inner-tls-{{ index . 1 }}, mountPath: /inner-tls, readOnly: true}
{{- end }}
{{- end -}}

{{- define "diaphane.innerTlsVolumes" -}}
{{- if include "diaphane.innerTlsSecrets" (index . 0) }}
- name: inner-tls-{{ index . 1 }}
  secret:
    secretName: {{ include "diaphane.innerTlsSecret" . }}
    defaultMode: 0440
    items: [{key: ca.crt, path: ca.crt}, {key: tls.crt, path: tls.crt}, {key: tls.key, path: tls.key}]
{{- end }}
{{- end -}}

{{/* The authority that signed Postgres's certificate, which libpq reads by this variable; `postgresCaMounts` and `postgresCaVolumes` go with it. */}}
{{- define "diaphane.postgresCa" -}}
{{- if .Values.postgres.caSecretName }}
- {name: PGSSLROOTCERT, value: /postgres-ca/ca.crt}
{{- end }}
{{- end -}}

{{- define "diaphane.postgresCaMounts" -}}
{{- if .Values.postgres.caSecretName }}
- {name: postgres-ca, mountPath: /postgres-ca, readOnly: true}
{{- end }}
{{- end -}}

{{- define "diaphane.postgresCaVolumes" -}}
{{- with .Values.postgres.caSecretName }}
- name: postgres-ca
  secret:
    secretName: {{ . }}
    defaultMode: 0440
    items: [{key: ca.crt, path: ca.crt}]
{{- end }}
{{- end -}}

{{- define "diaphane.redisPort" -}}
{{ include "diaphane.redis" . | splitList ":" | last }}
{{- end -}}

{{- define "diaphane.secret" -}}
{{ required "existingSecret is missing: set it to the name of a secret with the keys postgres, mail and factor-key (README.md)" .Values.existingSecret }}
{{- end -}}

{{- define "diaphane.claim" -}}
{{- $of := index (index . 0).Values.storage (index . 1) -}}
{{ $of.existingClaim | default (printf "%s-%s" (include "diaphane.name" (index . 0)) (index . 1)) }}
{{- end -}}

{{/* Pod Security "restricted", and a root that nobody writes to. */}}
{{- define "diaphane.podSecurity" -}}
runAsNonRoot: true
runAsUser: 10001
runAsGroup: 10001
fsGroup: 10001
fsGroupChangePolicy: OnRootMismatch
seccompProfile: {type: RuntimeDefault}
{{- end -}}

{{- define "diaphane.containerSecurity" -}}
allowPrivilegeEscalation: false
readOnlyRootFilesystem: true
capabilities: {drop: [ALL]}
{{- end -}}

{{/* What a pod of ours has beside containers and volumes: a list of the root, the values of the component. */}}
{{- define "diaphane.pod" -}}
{{- $root := index . 0 -}}{{- $part := index . 1 -}}
automountServiceAccountToken: false
enableServiceLinks: false
securityContext:
  {{- include "diaphane.podSecurity" $root | nindent 2 }}
{{- with $root.Values.image.pullSecrets }}
imagePullSecrets:
  {{- range . }}
  - name: {{ . }}
  {{- end }}
{{- end }}
{{- with $root.Values.priorityClassName }}
priorityClassName: {{ . }}
{{- end }}
{{- with $part.nodeSelector }}
nodeSelector: {{ toJson . }}
{{- end }}
{{- with $part.tolerations }}
tolerations: {{ toJson . }}
{{- end }}
{{- end -}}

{{/* Spread over nodes, and over zones where there are any: a list of the root and the component. Zones by anti-affinity: a second spread constraint
     would make the scheduler pass over the first on nodes that have no zone. */}}
{{- define "diaphane.spread" -}}
{{- $on := . -}}
topologySpreadConstraints:
  - maxSkew: 1
    topologyKey: kubernetes.io/hostname
    whenUnsatisfiable: ScheduleAnyway
    labelSelector:
      matchLabels:
        {{- include "diaphane.selector" $on | nindent 8 }}
affinity:
  podAntiAffinity:
    preferredDuringSchedulingIgnoredDuringExecution:
      - weight: 100
        podAffinityTerm:
          topologyKey: topology.kubernetes.io/zone
          labelSelector:
            matchLabels:
              {{- include "diaphane.selector" $on | nindent 14 }}
{{- end -}}

{{/* Of the admin port, called with its name: alive says nothing of what it depends on. */}}
{{- define "diaphane.probes" -}}
startupProbe:
  httpGet: {path: /healthz, port: {{ . }}}
  periodSeconds: 2
  failureThreshold: 60
livenessProbe:
  httpGet: {path: /healthz, port: {{ . }}}
  periodSeconds: 10
  timeoutSeconds: 3
  failureThreshold: 3
readinessProbe:
  httpGet: {path: /readyz, port: {{ . }}}
  periodSeconds: 3
  timeoutSeconds: 2
  failureThreshold: 2
{{- end -}}

{{- define "diaphane.extraEnv" -}}
{{- range $name, $value := . }}
- name: {{ $name }}
  value: {{ $value | quote }}
{{- end }}
{{- end -}}

{{- define "diaphane.fromSecret" -}}
valueFrom: {secretKeyRef: {name: {{ include "diaphane.secret" (index . 0) }}, key: {{ index . 1 }}}}
{{- end -}}
