use super::*;
use crate::export::exr::to_bytes;
use crate::table::samples::{grey_2d, rgb_1d, scalar};
use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

/// Keeps the tables under the keys of their requests, publishes them, and returns the manifest.
fn bake(store: &Store, tables: &[(Table, &str)]) -> Manifest {
    let mut requests = BTreeMap::new();
    let entry = |(table, request): &(Table, &str)| {
        let (bytes, key) = (to_bytes(table).unwrap(), key(request));
        if store.find(&key, &table.id, &|_| true).kept.is_none() {
            store.keep(&key, &bytes).unwrap();
        }
        requests.insert(table.id.clone(), key);
        TableEntry::new(table, file_name(&table.id), bytes.len() as u64, sha256_hex(&bytes), &[])
    };
    let entries = tables.iter().map(entry).collect();
    let manifest = Manifest::new("s", 0, &[], entries, requests);
    store.publish(&manifest).unwrap();
    manifest
}

fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn holds_table(path: &Path, table: &Table) -> bool {
    fs::read(path).unwrap() == to_bytes(table).unwrap()
}

/// A table of the same name with another value: as if a parameter had changed.
fn changed(value: f64) -> Table {
    let mut table = scalar();
    table.values[0] = glam::DVec3::splat(value);
    table
}

#[test]
fn tables_of_one_request_share_an_entry() {
    let directory = tempfile::tempdir().unwrap();
    let named = |id: &str| Table {
        id: id.into(),
        ..rgb_1d()
    };
    // kept twice before either is published, as by a bake that has not noticed
    let store = Store::open(directory.path()).unwrap();
    let key = key("same");
    for _ in 0..2 {
        store.keep(&key, &to_bytes(&rgb_1d()).unwrap()).unwrap();
    }
    let tables = [(named("a"), "same"), (named("b"), "same")];
    bake(&store, &tables);
    drop(store);
    assert_eq!(names(directory.path()), [".furnace", "a.exr", "b.exr", "manifest.json"]);
    assert_eq!(names(&directory.path().join(CACHE)).len(), 1);
    for id in ["a", "b"] {
        assert!(holds_table(&directory.path().join(file_name(id)), &rgb_1d()));
    }
    // both are found, each under its name
    let store = Store::open(directory.path()).unwrap();
    for id in ["a", "b"] {
        assert_eq!(store.find(&key, id, &|_| true).kept.unwrap().table.id, id);
    }
    assert_eq!(store.abandon().tables, 2);
}

#[test]
fn tables_of_other_requests_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    bake(&Store::open(directory.path()).unwrap(), &[(scalar(), "one")]);
    let store = Store::open(directory.path()).unwrap();
    assert_eq!(store.find(&key("other"), "a", &|_| true), Lookup::default());
    assert_eq!(store.find("", "a", &|_| true), Lookup::default());
    // under the right key, but not what it should be, in the cache and in place
    let lookup = store.find(&key("one"), "a", &|table| table.quantity.name() == "rho_hd");
    assert_eq!((lookup.kept, lookup.damaged.len()), (None, 2));
    assert!(lookup.damaged[0].to_string().contains("another table"));
    assert!(names(&directory.path().join(CACHE)).is_empty());
    assert!(
        store.find(&key("one"), "a", &|_| true).kept.is_some(),
        "the one in place stays"
    );
}

/// Those go first that were used longest ago, and none that is in use.
#[test]
fn what_is_too_much_goes_by_its_last_use() {
    let directory = tempfile::tempdir().unwrap();
    let cache = directory.path().join(CACHE);
    let requests = ["0", "1", "2", "3", "4"];
    // the size of each is one block, whatever it holds
    const LIMIT: u64 = 2 * 4096;
    let open = || Store::open(directory.path()).unwrap().with_limit(LIMIT);
    let has = |request: &str| names(&cache).iter().any(|name| name.starts_with(short(&key(request))));
    let age = |request: &str, seconds: u64| {
        let name = names(&cache)
            .into_iter()
            .find(|name| name.starts_with(short(&key(request))));
        let file = File::options().write(true).open(cache.join(name.unwrap())).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_secs(seconds))
            .unwrap();
    };
    let use_one = |index: usize| bake(&open(), &[(changed(index as f64), requests[index])]);
    use_one(0);
    use_one(1);
    use_one(2);
    assert!(has("0") && has("1") && has("2"), "two that are not in use are allowed");
    age("0", 200);
    age("1", 300);
    // 1 is used again, 2 has just been used: of 0 and 2 none has to go
    use_one(1);
    assert!(has("0") && has("1") && has("2"));
    age("1", 400);
    // out of use 1 was used last, whatever time it had while it was in use
    use_one(3);
    assert!(!has("0") && has("1") && has("2") && has("3"), "{:?}", names(&cache));
    // what is in use does not count and never goes
    let store = Store::open(directory.path()).unwrap().with_limit(0);
    bake(
        &store,
        &[
            (changed(3.0), "3"),
            (
                Table {
                    id: "x".into(),
                    ..changed(4.0)
                },
                "4",
            ),
        ],
    );
    assert_eq!(names(&cache).len(), 2);
    assert!(has("3") && has("4"));
}

#[test]
fn links_take_no_room_and_copies_are_made_where_there_are_none() {
    let directory = tempfile::tempdir().unwrap();
    let manifest = bake(&Store::open(directory.path()).unwrap(), &[(grey_2d(), "one")]);
    let entry = directory
        .path()
        .join(CACHE)
        .join(entry_of(&manifest, &manifest.tables[0]));
    let place = directory.path().join(&manifest.tables[0].file);
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let file = |path: &Path| fs::metadata(path).unwrap().ino();
        assert_eq!(file(&entry), file(&place));
    }
    // the way without links, and with them that around a file that only points to another
    let [copy, other, pointing] = ["copy", "other", "pointing"].map(|name| directory.path().join(name));
    entries::copy(&entry, &copy).unwrap();
    assert!(holds_table(&copy, &grey_2d()));
    assert!(entries::copy(&entry, &copy).is_err(), "nothing is written over");
    assert_eq!(
        link_or_copy(&directory.path().join("none"), &other).unwrap_err().kind(),
        ErrorKind::NotFound
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&entry, &pointing).unwrap();
        link_or_copy(&pointing, &other).unwrap();
        assert!(fs::symlink_metadata(&other).unwrap().is_file() && holds_table(&other, &grey_2d()));
    }
    // a copy in place is as good as a link: it is found and not touched
    fs::remove_file(&place).unwrap();
    fs::rename(&copy, &place).unwrap();
    let before = fs::metadata(&place).unwrap().modified().unwrap();
    bake(&Store::open(directory.path()).unwrap(), &[(grey_2d(), "one")]);
    assert_eq!(fs::metadata(&place).unwrap().modified().unwrap(), before);
}

/// A version that gives other bytes to the same request, as in the midst of its development: the latest are right.
#[test]
fn computing_again_replaces_what_was_known() {
    let directory = tempfile::tempdir().unwrap();
    let (cache, place) = (
        directory.path().join(CACHE),
        directory.path().join(file_name(&scalar().id)),
    );
    let open = || Store::open(directory.path()).unwrap();
    bake(&open(), &[(changed(0.25), "one")]);
    bake(&open(), &[(changed(0.75), "other")]);
    let found = |request: &str| {
        let kept = open().find(&key(request), "a", &|_| true).kept;
        kept.map(|kept| kept.table.values[0].x)
    };
    assert_eq!((found("one"), found("other")), (Some(0.25), Some(0.75)));
    bake(&open().without_cache(), &[(changed(0.5), "one")]);
    assert!(holds_table(&place, &changed(0.5)));
    assert_eq!(names(&cache).len(), 1, "its own entry does not stay");
    assert_eq!((found("one"), found("other")), (Some(0.5), Some(0.75)));
}

/// What versions with another layout have left: manifests, and entries whose keys nobody has any more.
#[test]
fn leftovers_of_other_layouts_are_not_trusted() {
    let directory = tempfile::tempdir().unwrap();
    let cache = directory.path().join(CACHE);
    fs::create_dir(&cache).unwrap();
    let bytes = to_bytes(&scalar()).unwrap();
    let old = entry_name(
        &sha256_hex(format!("whitefurnace {VERSION}, layout 1\none").as_bytes()),
        &sha256_hex(&bytes),
    );
    fs::write(cache.join(&old), &bytes).unwrap();
    for name in ["manifest.json", ".furnace-abc.part", "7.part"] {
        fs::write(cache.join(name), b"{}").unwrap();
    }
    let store = Store::open(directory.path()).unwrap();
    assert_eq!(names(&cache), [old]);
    assert_eq!(store.find(&key("one"), "a", &|_| true), Lookup::default());
}

/// A table that has vanished is met before the first name changes hands, and the next try goes through.
#[test]
fn nothing_is_replaced_unless_everything_can_be() {
    let directory = tempfile::tempdir().unwrap();
    let second = |value: f64| Table {
        id: "second".into(),
        ..changed(value)
    };
    bake(
        &Store::open(directory.path()).unwrap(),
        &[(changed(0.25), "1"), (second(0.5), "2")],
    );
    let before = fs::read(directory.path().join(manifest::FILE_NAME)).unwrap();
    let store = Store::open(directory.path()).unwrap();
    let (one, other) = (changed(0.75), second(0.125));
    let mut requests = BTreeMap::new();
    let tables = [(&one, "3"), (&other, "4")].map(|(table, request)| {
        let bytes = to_bytes(table).unwrap();
        store.keep(&key(request), &bytes).unwrap();
        requests.insert(table.id.clone(), key(request));
        TableEntry::new(table, file_name(&table.id), bytes.len() as u64, sha256_hex(&bytes), &[])
    });
    let manifest = Manifest::new("s", 0, &[], tables.to_vec(), requests);
    let gone = directory
        .path()
        .join(CACHE)
        .join(entry_of(&manifest, &manifest.tables[1]));
    let away = directory.path().join("away");
    fs::rename(&gone, &away).unwrap();
    let error = store.publish(&manifest).unwrap_err();
    assert!(matches!(error, ExportError::Vanished { path } if path == gone));
    assert_eq!(fs::read(directory.path().join(manifest::FILE_NAME)).unwrap(), before);
    assert!(holds_table(&directory.path().join(file_name(&one.id)), &changed(0.25)));
    assert_eq!(
        *store.abandon(),
        Finished {
            tables: 2,
            published: false
        }
    );
    // parts of what was tried are gone, and the next try goes through
    assert!(
        names(&directory.path().join(CACHE))
            .iter()
            .all(|name| name.ends_with(".exr"))
    );
    fs::rename(&away, &gone).unwrap();
    store.publish(&manifest).unwrap();
    assert!(holds_table(&directory.path().join(file_name("second")), &other));
    assert!(store.abandon().published);
}
