BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0004');
CREATE TABLE maps (
	number INTEGER NOT NULL, 
	id TEXT NOT NULL, 
	last_seen_s FLOAT NOT NULL, 
	PRIMARY KEY (number), 
	UNIQUE (id)
);
INSERT INTO "maps" VALUES(0,'',0.0);
CREATE TABLE things (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	label TEXT NOT NULL, 
	x FLOAT NOT NULL, 
	y FLOAT NOT NULL, 
	z FLOAT NOT NULL, 
	variance_m2 FLOAT NOT NULL, 
	belief FLOAT NOT NULL, 
	believed_s FLOAT NOT NULL, 
	confidence FLOAT NOT NULL, 
	first_seen_s FLOAT NOT NULL, 
	last_seen_s FLOAT NOT NULL, 
	times_seen INTEGER NOT NULL, 
	colours TEXT NOT NULL, 
	times_missed INTEGER NOT NULL, 
	last_missed_s FLOAT, 
	miss_x FLOAT NOT NULL, 
	miss_y FLOAT NOT NULL, 
	miss_loss FLOAT NOT NULL, 
	moved_from INTEGER, 
	moved_to INTEGER, 
	embedding_model TEXT NOT NULL, 
	embedding BLOB NOT NULL, map_number INTEGER DEFAULT '0' NOT NULL, 
	FOREIGN KEY(moved_from) REFERENCES things (id) ON DELETE SET NULL, 
	FOREIGN KEY(moved_to) REFERENCES things (id) ON DELETE SET NULL
);
INSERT INTO "things" VALUES(1,'bottle',2.0,1.5,0.3,6.89855072463768127788e-03,0.95,1700000060.0,0.9,1700000000.0,1700000060.0,2,'{"red": 1.9}',0,NULL,0.0,0.0,1.0,NULL,NULL,'',X'',0);
INSERT INTO "things" VALUES(2,'chair',5.0,0.5,0.3,1.36000000000000009769e-02,9.15254237288135596983e-01,1700000100.0,0.7,1700000100.0,1700000100.0,1,'{}',0,NULL,0.0,0.0,1.0,NULL,NULL,'',X'',0);
CREATE TABLE "views" (
	id INTEGER NOT NULL, 
	label TEXT NOT NULL, 
	colour TEXT NOT NULL, 
	cell_x INTEGER NOT NULL, 
	cell_y INTEGER NOT NULL, 
	sector INTEGER NOT NULL, 
	thing_id INTEGER, 
	x FLOAT NOT NULL, 
	y FLOAT NOT NULL, 
	yaw FLOAT NOT NULL, 
	confidence FLOAT NOT NULL, 
	last_seen_s FLOAT NOT NULL, 
	sightings INTEGER NOT NULL, 
	belief FLOAT NOT NULL, 
	believed_s FLOAT NOT NULL, map_number INTEGER DEFAULT '0' NOT NULL, 
	PRIMARY KEY (id), 
	FOREIGN KEY(thing_id) REFERENCES things (id) ON DELETE CASCADE
);
INSERT INTO "views" VALUES(1,'bottle','',4,4,0,1,1.0,1.0,0.5,0.9,1700000060.0,2,0.945054945054945,1700000060.0,0);
INSERT INTO "views" VALUES(2,'cup','blue',12,-4,3,NULL,3.0,-1.0,1.6,0.6,1700000090.0,1,8.91304347826086917905e-01,1700000090.0,0);
INSERT INTO "views" VALUES(3,'chair','',16,0,0,2,4.0,0.0,0.0,0.7,1700000100.0,1,9.15254237288135596983e-01,1700000100.0,0);
CREATE INDEX views_of_thing ON views (thing_id, label, confidence DESC);
CREATE INDEX things_of_label ON things (map_number, label);
CREATE INDEX things_at ON things (map_number, x, y);
CREATE UNIQUE INDEX views_place ON views (map_number, cell_x, cell_y, sector, label, colour, coalesce(thing_id, 0));
CREATE INDEX views_best_first ON views (map_number, label, confidence DESC);
CREATE INDEX views_of_colour ON views (map_number, label, colour, confidence DESC) WHERE thing_id IS NULL;
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('things',2);
COMMIT;
