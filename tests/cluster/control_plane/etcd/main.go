// etcd as its own project builds it: https://github.com/etcd-io/etcd/blob/main/server/main.go
package main

import (
	"os"

	"go.etcd.io/etcd/server/v3/etcdmain"
)

func main() {
	etcdmain.Main(os.Args)
}
